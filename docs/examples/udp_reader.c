/* Read calibrated samples over UDP, on a little-endian machine: cc -std=c99 -D_DEFAULT_SOURCE udp_reader.c */
#include <arpa/inet.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct sample {
    char magic[4]; uint32_t flags; uint64_t sequence;
    double t, utc, f[3], omega[3], temperature; uint32_t lost, run;
};

int main(int argc, char **argv)
{
    struct sample s;
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons((uint16_t)atoi(argv[argc - 1])),
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    int port = socket(AF_INET, SOCK_DGRAM, 0), room = 4 << 20;
    setsockopt(port, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    if (bind(port, (struct sockaddr *)&at, sizeof at) != 0) return 1;
    uint64_t next = 0, missed = 0;
    uint32_t run = 0;
    while (recv(port, &s, sizeof s, 0) == sizeof s)
        if (memcmp(s.magic, "FOG1", 4) == 0) {
            if (next != 0 && s.run == run && s.sequence > next) {
                missed += s.sequence - next;
                fprintf(stderr, "missed %llu so far\n", (unsigned long long)missed);
            }
            run = s.run;
            next = s.sequence + 1;
            printf("%llu %.17g %.17g %.17g %.17g %.17g %.17g %.17g %#x\n", (unsigned long long)s.sequence, s.t,
                   s.f[0], s.f[1], s.f[2], s.omega[0], s.omega[1], s.omega[2], (unsigned)s.flags);
            fflush(stdout);
        }
}
