"""Radiance .hdr files: what shared exponents leave of an image, and writing it."""
import numpy as np


def rounded(image):
    """The values that a file keeps of an image (rows of RGB)."""
    mantissas, exponents = packed(image)
    return mantissas * np.exp2(exponents - 136.0)[..., None] * (mantissas.any(-1, keepdims=True))


def packed(image):
    image = np.asarray(image, float)
    _, power = np.frexp(image.max(-1))
    exponents = np.where(image.max(-1) > 1e-32, power + 128, 0)
    mantissas = np.floor(image * np.exp2(136.0 - exponents)[..., None])
    return np.clip(mantissas, 0, 255), exponents


def write(path, image):
    """Flat, without run lengths."""
    mantissas, exponents = packed(image)
    pixels = np.concatenate([mantissas, exponents[..., None]], -1).astype(np.uint8)
    with open(path, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {pixels.shape[0]} +X {pixels.shape[1]}\n".encode())
        file.write(pixels.tobytes())
