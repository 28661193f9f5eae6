"""Reads the scan-line OpenEXR files that lightbatch writes (half or float, no compression, ZIPS or ZIP) with numpy alone."""
import pathlib
import struct
import zlib

import numpy as np

TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
LINES_IN_BLOCK = {0: 1, 2: 1, 3: 16}  # by compression: none, ZIPS, ZIP


def read_header(data):
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630 or version & 0x1A00:
        raise ValueError("no single-part scan-line OpenEXR file")
    at, attributes = 8, {}
    while data[at]:
        name_end = data.index(0, at)
        kind_end = data.index(0, name_end + 1)
        size = struct.unpack_from("<I", data, kind_end + 1)[0]
        attributes[data[at:name_end].decode()] = data[kind_end + 5:kind_end + 5 + size]
        at = kind_end + 5 + size
    return attributes, at + 1


def channels_of(value):
    at, channels = 0, []
    while value[at]:
        end = value.index(0, at)
        channels.append((value[at:end].decode(), TYPES[struct.unpack_from("<I", value, end + 1)[0]]))
        at = end + 17
    return channels


def unpack(block, size):
    """Undoes ZIP: zlib, then the byte differences, then the two interleaved halves."""
    if len(block) == size:
        return block
    packed = np.frombuffer(zlib.decompress(block), np.uint8)
    plain = (np.cumsum(packed, dtype=np.int64) - 128 * np.arange(len(packed))).astype(np.uint8)
    out, half = np.empty_like(plain), (len(plain) + 1) // 2
    out[0::2], out[1::2] = plain[:half], plain[half:]
    return out.tobytes()


def read(path):
    """{channel: (height, width) float32}, row 0 on top."""
    data = pathlib.Path(path).read_bytes()
    attributes, at = read_header(data)
    x0, y0, x1, y1 = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    compression, channels = attributes["compression"][0], channels_of(attributes["channels"])
    lines = LINES_IN_BLOCK[compression]
    images = {name: np.zeros((height, width), np.float32) for name, _ in channels}
    row_size = sum(kind.itemsize for _, kind in channels) * width
    for offset in struct.unpack_from(f"<{(height + lines - 1) // lines}Q", data, at):
        y, size = struct.unpack_from("<iI", data, offset)
        rows = min(lines, y1 + 1 - y)
        block = unpack(data[offset + 8:offset + 8 + size], row_size * rows)
        place = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in channels:
                images[name][row] = np.frombuffer(block, kind, width, place)
                place += kind.itemsize * width
    return images


def read_rgb(path):
    """(height, width, 3) linear RGB, and coverage (height, width)."""
    images = read(path)
    rgb = np.stack([images[c] for c in "RGB"], -1)
    return rgb, images.get("A", np.ones(rgb.shape[:2], np.float32))
