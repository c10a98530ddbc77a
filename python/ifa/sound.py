"""Sound files: any format that libsndfile reads, and PCM WAV to write."""

import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ifa import _core
from ifa.arguments import array

FilePath = str | os.PathLike[str]


def file_name(path: FilePath) -> str:
    """The path as a string; IfaFileError for one that no file can have, else IfaValueError."""
    try:
        name = os.fspath(path)
    except TypeError:
        raise _core.IfaValueError(f"path: must name a file, got {path!r}") from None
    if not isinstance(name, str) or not name or "\0" in name:
        raise _core.IfaFileError(f"{name!r} is no file name")
    return name


def read_sound(path: FilePath) -> tuple[NDArray[np.float64], int]:
    """Read a sound file as one channel.

    Args:
        path: WAV, AIFF, FLAC, Ogg and whatever else libsndfile reads.

    Returns:
        The samples, shape (n,), channels averaged, full scale -1 to 1, and the sample rate in Hz.

    Raises:
        IfaFileError: The file is missing, a folder, no sound, damaged or empty, has a sample that
            is not finite, or is longer than 2^28 samples.
    """
    samples, sample_rate_hz = _core.read_sound(file_name(path))
    return samples, sample_rate_hz


def write_wav(path: FilePath, samples: ArrayLike, sample_rate_hz: int, bits: int = 16) -> None:
    """Write one channel as a PCM WAV file, which appears whole or not at all.

    Args:
        path: The file, replaced if it exists.
        samples: Shape (n,), from -1 to 1; nothing is clipped silently.
        sample_rate_hz: From 1 kHz to 1 MHz.
        bits: 16 or 24 for each sample.

    Raises:
        IfaValueError: A sample is out of range or not a number, or another argument is bad.
        IfaFileError: The file cannot be written.
    """
    _core.write_wav(file_name(path), array(samples, "samples", (None,)), sample_rate_hz, bits)
