"""Frames to samples: those of one counter, or of one turn of the bus, belong together.

A sample is given out when its last frame has come and none before it may still become whole. One whose frames
are late beyond the next sample's end is given up and counted. The host's clock helps to unwrap counters.
"""

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.can.dbc_signals import SignalField, Words, words_of
from drivers.can.frame_record import NO_DATA_FRAME, RECORD, SenderWatch
from drivers.can.mapping_file import CHECKS, CanMap
from drivers.wire import FrameCounters
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import CountBlock, RateBlock, SampleBlock

MAX_LATE_SAMPLES = 2  # samples: how far the bus may have gone on before a frame is given up
MAX_JUMP_SAMPLES = 8  # samples: what lies further off is of a device that restarted, or of another one
MAX_ASIDE_FRAMES = 16  # frames that come now and then which may wait for their sample
MAX_ASIDE_BYTES = 64 * RECORD.itemsize  # bytes: a frame that comes now and then is this near to its sample
FRAME = np.dtype(
    [("slot", "i8"), ("u", "i8"), ("at", "i8"), ("host_ns", "i8"), ("little", "u8"), ("big", "u8"), ("raw", "i8")]
)
Frames = NDArray[np.void]  # (n,) of FRAME: slot, sample number, place in the stream, host time, payload, counter


class CanJoiner:
    """Joins one device's frames, in the order they came; ``counters`` says what was met besides."""

    def __init__(self, can_map: CanMap, counters: FrameCounters) -> None:
        self._map, self._counters = can_map, counters
        self._matches = list[tuple[np.uint32, NDArray[np.uint32], IntArray]]()  # mask, identifiers, their slots
        for mask in sorted({slot.mask for slot in can_map.slots}):
            alike = [i for i, slot in enumerate(can_map.slots) if slot.mask == mask]
            keys = np.array([can_map.slots[i].identifier & mask for i in alike], dtype=np.uint32)
            order = np.argsort(keys)
            self._matches.append((np.uint32(mask), keys[order], np.array(alike)[order]))
        senders = {slot.sender for slot in can_map.slots if slot.sender is not None}
        self._senders: dict[int, list[int]] = {
            each: [i for i, slot in enumerate(can_map.slots) if slot.sender == each] for each in senders
        }
        self._watch = SenderWatch(can_map.path)
        # slots whose frames are numbered and checked alike, by counter, check and size
        self._groups = dict[tuple[SignalField | None, SignalField | None, int], list[int]]()
        for i, slot in enumerate(can_map.slots):
            self._groups.setdefault((slot.counter, slot.check, slot.size), []).append(i)
        self._period_ns = can_map.period * 1e9
        self._waiting = np.zeros(0, FRAME)
        self._aside = np.zeros(0, FRAME)  # frames that come now and then, until their sample is whole
        self._reference: tuple[int, int, int] | None = None  # counter, number, host time of the newest frame
        self._last: int | None = None  # the newest sample given out
        self._given = deque[Frames](maxlen=MAX_JUMP_SAMPLES + 1)  # of the newest samples given out
        self._base: tuple[int, int, IntArray] | None = None  # number, begin and running totals of the last sample
        self._time: tuple[int, int] | None = None  # as sent, unwrapped
        self._nothing = self._samples(self._waiting, np.zeros((0, can_map.needed), np.int64), np.arange(0))[0]

    def take(self, records: NDArray[np.void], at: IntArray) -> tuple[SampleBlock, IntArray]:
        """Return the samples that records (n,) at places ``at`` (n,) [bytes into the stream] complete.

        Next to them stands (m, 2) where the bytes of each begin and end there.
        """
        if not len(records):
            return self._nothing, np.zeros((0, 2), np.int64)
        frames = self._numbered(self._known(records, at))
        is_needed = frames["slot"] < self._map.needed
        self._aside = np.concatenate((self._aside, frames[~is_needed]))
        waiting = np.concatenate((self._waiting, frames[is_needed]))
        rows, ends = self._whole_turns(waiting)
        if rows is None:
            rows, ends = self._one_by_one(waiting)
        if len(rows):
            self._given.append(waiting[rows[-MAX_JUMP_SAMPLES - 1 :]])
        return self._samples(waiting, rows, ends)

    def _known(self, records: NDArray[np.void], at: IntArray) -> Frames:
        """Return the frames that belong to the device and pass length and check."""
        ids = records["id"]
        slot = np.full(len(ids), -1)
        for mask, keys, those in self._matches:
            wanted = ids & mask
            place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            slot = np.where(keys[place] == wanted, those[place], slot)
        known = slot >= 0
        if not known.all():
            errors = (ids & NO_DATA_FRAME) != 0
            self._counters.bus_errors += int(np.count_nonzero(errors))
            self._counters.foreign += int(np.count_nonzero(~known & ~errors))
            records, at, slot = records[known], at[known], slot[known]
        frames = np.zeros(len(records), FRAME)
        frames["slot"], frames["at"], frames["host_ns"] = slot, at, records["host_ns"]
        words = words_of(records["data"])
        frames["little"], frames["big"] = words
        good = np.ones(len(records), dtype=np.bool_)
        for (counter, check, size), slots in self._groups.items():
            rows = np.flatnonzero(np.isin(slot, slots)) if len(self._groups) > 1 else slice(None)
            good[rows] = self._is_good(check, size, records[rows])
            if counter is not None:
                frames["raw"][rows] = counter.raw((words[0][rows], words[1][rows]))
        for sender, own in self._senders.items():
            if (its := good & np.isin(slot, own)).any():
                self._watch.look(sender, records["id"][its])
        return frames if good.all() else frames[good]

    def _is_good(self, check: SignalField | None, size: int, records: NDArray[np.void]) -> NDArray[np.bool_]:
        sizes = records["size"]
        good = (sizes >= size) & (sizes <= 8) if self._map.is_padded else sizes == size
        self._counters.bad_length += int(np.count_nonzero(~good))
        if check is not None:
            byte = check.shift // 8 if not check.is_big_endian else 7 - check.shift // 8
            rest = np.delete(records["data"][:, :size], byte, axis=1)
            passes = CHECKS[self._map.check_kind](records["id"], rest) == records["data"][:, byte]
            self._counters.bad_crc += int(np.count_nonzero(good & ~passes))
            good &= passes
        return good

    def _numbered(self, frames: Frames) -> Frames:
        """Say of each frame which sample, counted without wrapping, it belongs to."""
        if not len(frames):
            return frames
        if not self._map.counts_every_frame:
            return self._by_order(frames)
        field = self._map.slots[0].counter
        assert field is not None
        modulus, raw, host = 1 << field.bits, frames["raw"], frames["host_ns"]
        counter, number, since = self._reference or (int(raw[0]), int(raw[0]), int(host[0]))
        elapsed = np.rint(np.diff(host, prepend=since) / self._period_ns).astype(np.int64)
        steps = np.diff(raw, prepend=counter) - elapsed
        steps = (steps + modulus // 2) % modulus - modulus // 2 + elapsed
        frames["u"] = number + np.cumsum(steps)
        self._reference = int(raw[-1]), int(frames["u"][-1]), int(host[-1])
        return frames

    def _by_order(self, frames: Frames) -> Frames:
        begins = frames["slot"] == self._map.first
        _, number, since = self._reference or (0, 0, int(frames["host_ns"][0]))
        frames["u"] = number + np.cumsum(begins)
        newest = np.maximum.accumulate(np.where(begins, np.arange(len(frames)), -1))
        began = np.where(newest >= 0, frames["host_ns"][np.maximum(newest, 0)], since)
        self._reference = 0, int(frames["u"][-1]), int(began[-1])
        in_time = frames["host_ns"] - began < self._period_ns
        self._counters.late += int(np.count_nonzero(~in_time))
        return frames[in_time]

    def _whole_turns(self, waiting: Frames) -> tuple[IntArray | None, IntArray]:
        """Return the frames of each sample where all are there, sample by sample: nearly always."""
        size = self._map.needed
        whole = waiting[: len(waiting) // size * size].reshape(-1, size)
        tail, numbers = waiting[whole.size :], whole["u"]
        low = -(2**62) if self._last is None else self._last
        if not (
            (numbers == numbers[:, :1]).all()
            and (np.diff(np.concatenate(([low], numbers[:, 0], tail["u"][:1]))) > 0).all()
            and (tail["u"] == tail["u"][:1]).all()
            and len(set(tail["slot"].tolist())) == len(tail)
            and (np.sort(whole["slot"], axis=1) == np.arange(size)).all()
        ):
            return None, np.zeros(0, np.int64)
        rows = np.argsort(whole["slot"], axis=1) + size * np.arange(len(whole))[:, None]
        self._waiting = tail
        if len(whole):
            self._last = int(numbers[-1, 0])
        return rows, whole["at"][:, -1] + RECORD.itemsize

    def _one_by_one(self, waiting: Frames) -> tuple[IntArray, IntArray]:
        """Return the same where frames are missing, late, doubled or of two devices."""
        pending: dict[int, list[int]] = {}
        rows, ends = list[list[int]](), list[int]()
        payloads, given = waiting["little"].tolist(), dict[int, list[int]]()
        for newest in self._given:
            given |= zip(newest["u"][:, 0].tolist(), newest["little"].tolist(), strict=True)
        for i, (u, slot, at) in enumerate(
            zip(*(waiting[name].tolist() for name in ("u", "slot", "at")), strict=True)
        ):
            if self._last is not None and u < self._last - MAX_JUMP_SAMPLES:
                self._last = None  # the device restarted
            if self._last is not None and u <= self._last:
                self._counters.late += 1
                self._counters.contradicted += u in given and payloads[i] != given[u][slot]
                continue
            row = pending.setdefault(u, [-1] * self._map.needed)
            if row[slot] < 0:
                row[slot] = i
            elif payloads[row[slot]] == payloads[i]:
                self._counters.late += 1
            else:  # two devices, or a check passed by chance: neither is believed
                del pending[u]
                self._counters.incomplete += 1
                self._counters.contradicted += 1
                self._last = u
            for old in sorted(pending):
                if -1 not in pending[old] and old == min(pending):
                    rows.append(pending.pop(old))
                    given[old] = [payloads[k] for k in rows[-1]]
                    ends.append(at + RECORD.itemsize)
                    self._last = old
                elif not u - MAX_LATE_SAMPLES < old <= u + MAX_JUMP_SAMPLES:
                    del pending[old]
                    self._counters.incomplete += 1
        left = sorted(i for row in pending.values() for i in row if i >= 0)
        self._waiting = waiting[left]
        found = np.array(rows, np.int64).reshape(-1, self._map.needed)
        return found, np.array(ends, np.int64)

    def _samples(self, waiting: Frames, rows: IntArray, ends: IntArray) -> tuple[SampleBlock, IntArray]:
        found = waiting[rows]
        numbers = found["u"][:, 0]
        is_rate = self._map.output == "rate"
        channels: NDArray[Any] = np.zeros((len(rows), 6), np.float64 if is_rate else np.int64)
        status = np.zeros(len(rows), np.int64)
        temperature, time = np.full(len(rows), np.nan), np.float64(self._map.period) * numbers.astype(np.float64)
        counter = np.full(len(rows), -1, np.int64)
        is_known = np.ones(len(rows), np.bool_)  # J1939: a value that is an error or not available is unhealthy
        for i, slot in enumerate(self._map.slots[: self._map.needed]):
            words: Words = (found["little"][:, i], found["big"][:, i])
            for channel, field in slot.channels:
                channels[:, channel] = field.value(words) if is_rate else field.raw(words)
                if is_rate and slot.sender is not None:
                    is_known &= field.is_known(words, by_j1939=True)
            if slot.status is not None:
                status |= slot.status.raw(words)
            if slot.temperature is not None:
                temperature = slot.temperature.value(words)
            if slot.counter is not None:
                counter = found["raw"][:, i]
            if slot.time is not None:
                time = self._unwrapped(slot.time, slot.time.raw(words)).astype(np.float64) * self._map.time_unit
        begins = found["at"].min(axis=1) if len(rows) else ends
        begins = self._with_aside(numbers, begins, temperature)
        healthy = is_known & ((status & self._map.fault_bits) == 0)
        healthy &= (status & self._map.good_bits) == self._map.good_bits
        if not self._map.counts_every_frame and not any(slot.time for slot in self._map.slots):
            if (numbered := self._map.counter) is not None:
                time = self._unwrapped(numbered, counter).astype(np.float64) * self._map.period
            else:  # by the host's clock
                time = (found["host_ns"].min(axis=1) if len(rows) else numbers).astype(np.float64) * 1e-9
        kept = np.arange(len(rows))
        if self._map.output == "cumulative":
            channels, begins, kept = self._increments(numbers, begins, channels)
        block = (RateBlock if is_rate else CountBlock)(
            counter[kept], time[kept], channels[kept, :3], channels[kept, 3:], temperature[kept], status[kept],
            healthy[kept],
        )  # fmt: skip
        return block, np.stack((begins, ends), axis=1)[kept]

    def _with_aside(self, numbers: IntArray, begins: IntArray, temperature: FloatArray) -> IntArray:
        """Add what now and then comes with a sample; return where the samples' bytes then begin."""
        begins = begins.copy()
        for frame in self._aside:
            row = int(np.searchsorted(numbers, frame["u"]))
            if row < len(numbers) and numbers[row] == frame["u"] and frame["at"] > begins[row] - MAX_ASIDE_BYTES:
                begins[row] = min(begins[row], frame["at"])
                field = self._map.slots[frame["slot"]].temperature
                if field is not None:
                    temperature[row] = field.value((frame["little"][None], frame["big"][None]))[0]
        newer = self._aside["u"] > (numbers[-1] if len(numbers) else -(2**62))
        self._aside = self._aside[newer][-MAX_ASIDE_FRAMES:]
        return begins

    def _unwrapped(self, field: SignalField, raw: IntArray) -> IntArray:
        if not len(raw):
            return raw
        modulus = 1 << field.bits
        sent, whole = self._time or (int(raw[0]), int(raw[0]))
        steps = (np.diff(raw, prepend=sent) + modulus // 2) % modulus - modulus // 2
        unwrapped: IntArray = whole + np.cumsum(steps)
        self._time = int(raw[-1]), int(unwrapped[-1])
        return unwrapped

    def _increments(
        self, numbers: IntArray, begins: IntArray, totals: IntArray
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Return the steps of running totals; one without its predecessor only starts them."""
        if not len(numbers):
            return totals, begins, np.arange(0)
        number, begin, total = self._base or (int(numbers[0]), int(begins[0]), totals[0])
        steps = np.diff(totals, axis=0, prepend=total[None])
        for slot in self._map.slots:
            for channel, field in slot.channels:
                half = 1 << (field.bits - 1)
                if field.bits < 64:
                    steps[:, channel] = (steps[:, channel] + half) % (2 * half) - half
        kept = np.flatnonzero(np.diff(numbers, prepend=number) == 1)
        self._base = int(numbers[-1]), int(begins[-1]), totals[-1].copy()
        return steps, np.concatenate(([begin], begins[:-1])), kept
