/* A disk that fails or is slow, for one process: LD_PRELOAD this, then arm it for what lies below a folder.

   Counted are the calls that change a disk. The n-th is answered by an error, with `sticks` all after it too;
   with a delay each waits before it is done. SQLite and Python call the same functions. A process that is started
   with SLOW_DISK_BELOW, a folder, and SLOW_DISK_S is slow there from its beginning. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

enum { WRITES = 1, SYNCS = 2, NAMES = 4 };
static char below[PATH_MAX];
static int kinds, error_number, sticks;
static long fails_at, counted, failed;
static double delay_s; /* of several threads each waits for itself */

void arm_disk(const char *folder, int which, long nth, int error, int stays, double wait_s) {
    strncpy(below, folder, sizeof below - 1);
    kinds = which, fails_at = nth, error_number = error, sticks = stays, delay_s = wait_s;
    counted = failed = 0;
}
static void __attribute__((constructor)) slow_from_the_beginning(void) {
    const char *folder = getenv("SLOW_DISK_BELOW"), *wait = getenv("SLOW_DISK_S");
    if (folder && wait) arm_disk(folder, WRITES | SYNCS | NAMES, 0, 0, 0, atof(wait));
}
long calls_failed(void) { return failed; }

static int is_below(const char *path) { return below[0] && !strncmp(path, below, strlen(below)); }

static int fails(int kind, const char *path) {
    if (!(kinds & kind) || !is_below(path)) return 0;
    counted++;
    if (delay_s > 0) {
        struct timespec wait = {(time_t)delay_s, (long)((delay_s - (time_t)delay_s) * 1e9)};
        nanosleep(&wait, NULL);
    }
    if (!error_number || (counted != fails_at && !(sticks && counted > fails_at))) return 0;
    failed++, errno = error_number;
    return 1;
}

static int fails_at_file(int kind, int file) {
    char link[64], path[PATH_MAX];
    if (!below[0] || !(kinds & kind)) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0) return 0;
    path[length] = 0;
    return fails(kind, path);
}

#define REAL(name, result, ...) \
    static result (*real)(__VA_ARGS__); \
    if (!real) real = (result(*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

ssize_t write(int file, const void *data, size_t size) {
    REAL("write", ssize_t, int, const void *, size_t);
    return fails_at_file(WRITES, file) ? -1 : real(file, data, size);
}
ssize_t pwrite64(int file, const void *data, size_t size, off64_t at) {
    REAL("pwrite64", ssize_t, int, const void *, size_t, off64_t);
    return fails_at_file(WRITES, file) ? -1 : real(file, data, size, at);
}
ssize_t pwrite(int file, const void *data, size_t size, off_t at) {
    REAL("pwrite", ssize_t, int, const void *, size_t, off_t);
    return fails_at_file(WRITES, file) ? -1 : real(file, data, size, at);
}
int ftruncate64(int file, off64_t size) {
    REAL("ftruncate64", int, int, off64_t);
    return fails_at_file(WRITES, file) ? -1 : real(file, size);
}
int fsync(int file) {
    REAL("fsync", int, int);
    return fails_at_file(SYNCS, file) ? -1 : real(file);
}
int fdatasync(int file) {
    REAL("fdatasync", int, int);
    return fails_at_file(SYNCS, file) ? -1 : real(file);
}
int rename(const char *from, const char *to) {
    REAL("rename", int, const char *, const char *);
    return fails(NAMES, to) ? -1 : real(from, to);
}
int mkdir(const char *path, mode_t mode) {
    REAL("mkdir", int, const char *, mode_t);
    return fails(NAMES, path) ? -1 : real(path, mode);
}
#define OPENS(name) \
    int name(const char *path, int flags, ...) { \
        REAL(#name, int, const char *, int, ...); \
        va_list more; \
        va_start(more, flags); \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0; \
        va_end(more); \
        return flags & O_CREAT && fails(NAMES, path) ? -1 : real(path, flags, mode); \
    }
OPENS(open)
OPENS(open64)
