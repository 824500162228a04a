"""The same in Python, over libafferent.so and nothing else: embed_ctypes.py SCENE [libafferent.so]"""

import ctypes
import sys


class Event(ctypes.Structure):
    _fields_ = [("time_ns", ctypes.c_int64), ("address", ctypes.c_uint32)]


library = ctypes.CDLL(sys.argv[2] if len(sys.argv) > 2 else "libafferent.so.0")
library.afferent_open_file.restype = ctypes.c_void_p
library.afferent_error.restype = ctypes.c_char_p
library.afferent_advance.restype = ctypes.c_long

handle = library.afferent_open_file(sys.argv[1].encode())
if not handle:
    sys.exit(library.afferent_error(None).decode())
coprocessor = ctypes.c_void_p(handle)
forces_n = (ctypes.c_double * 3)(0.5, 0.4, 0.3)
events = (Event * 64)()
for now_ns in range(0, 1_000_000_000, 5_000_000):
    library.afferent_push(coprocessor, ctypes.c_int64(now_ns), 0, forces_n, ctypes.c_size_t(3))
    count = len(events)
    while count == len(events):
        end_ns = ctypes.c_int64(now_ns + 5_000_000)
        count = library.afferent_advance(coprocessor, end_ns, events, ctypes.c_size_t(len(events)))
        for event in events[:count]:
            print(f"{event.time_ns / 1e9:.9f} {event.address}")
library.afferent_close(coprocessor)
