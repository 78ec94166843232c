"""Read calibrated samples over UDP: `python udp_reader.py 5005`."""

import socket
import struct
import sys

SAMPLE = struct.Struct("<4sIQdd3d3ddII")
port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
port.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
port.bind(("127.0.0.1", int(sys.argv[1])))
last, missed = None, 0
while True:
    magic, flags, sequence, t, utc, fx, fy, fz, wx, wy, wz, temperature, lost, run = SAMPLE.unpack(port.recv(96))
    if magic != b"FOG1":
        continue
    if last is not None and last[0] == run and sequence > last[1] + 1:
        missed += sequence - last[1] - 1
        print(f"missed {missed} so far", file=sys.stderr)
    last = run, sequence
    print(sequence, t, fx, fy, fz, wx, wy, wz, f"{flags:#x}", flush=True)
