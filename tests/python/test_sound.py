"""Sound files through Python, against the standard library's `wave`."""

import os
import wave
from pathlib import Path

import ifa
import numpy as np
import pytest
from ifa.sound import read_sound, write_wav

SOUNDS = Path(__file__).parents[3] / "shared" / "sounds"


def tone(seconds: float = 0.1, rate_hz: int = 48000) -> np.ndarray:
    return 0.5 * np.sin(2 * np.pi * 440 * np.arange(int(seconds * rate_hz)) / rate_hz)


def test_read_gives_float64_samples_and_the_rate(tmp_path: Path) -> None:
    with wave.open(str(tmp_path / "a.wav"), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(22050)
        file.writeframes(np.array([[16384, 0], [-32768, -32768]], "<i2").tobytes())
    samples, rate_hz = read_sound(tmp_path / "a.wav")
    assert samples.dtype == np.float64
    assert samples.tolist() == [0.25, -1.0]
    assert rate_hz == 22050


def crc(data: bytes, polynomial: int, bits: int) -> bytes:
    """Of FLAC: most significant bit first, starting from 0."""
    value = 0
    for byte in data:
        value ^= byte << (bits - 8)
        for _ in range(8):
            value = (value << 1) ^ (polynomial if value >> (bits - 1) & 1 else 0)
            value &= (1 << bits) - 1
    return value.to_bytes(bits // 8, "big")


def constant_flac(value: int, rate_hz: int = 48000) -> bytes:
    """One frame of 16 equal 16-bit samples, after the format's definition (RFC 9639)."""
    packed = rate_hz << 44 | (16 - 1) << 36 | 16  # rate, one channel, bits, samples
    information = (16).to_bytes(2, "big") * 2 + bytes(6) + packed.to_bytes(8, "big") + bytes(16)
    header = bytes([0xFF, 0xF8, 0x6A, 0x08, 0x00, 16 - 1])  # block size follows; 48 kHz; 16 bits
    header += crc(header, 0x07, 8)
    frame = header + b"\0" + value.to_bytes(2, "big", signed=True)
    return b"fLaC\x80" + (34).to_bytes(3, "big") + information + frame + crc(frame, 0x8005, 16)


def test_other_formats_than_wav(tmp_path: Path) -> None:
    fields = [24, 4, 3, 44100, 1]  # header bytes, data bytes, 16-bit PCM, rate, channels
    au = b".snd" + b"".join(x.to_bytes(4, "big") for x in fields) + b"\x40\0\x80\0"
    (tmp_path / "a.au").write_bytes(au)
    samples, rate_hz = read_sound(tmp_path / "a.au")
    assert (samples.tolist(), rate_hz) == ([0.5, -1.0], 44100)
    (tmp_path / "a.flac").write_bytes(constant_flac(-8192))
    samples, rate_hz = read_sound(tmp_path / "a.flac")
    assert (samples.tolist(), rate_hz) == ([-0.25] * 16, 48000)


@pytest.mark.parametrize("bits", [16, 24])
def test_wave_reads_what_we_write(tmp_path: Path, bits: int) -> None:
    path = tmp_path / "out.wav"
    write_wav(path, tone(), 48000, bits)
    with wave.open(str(path), "rb") as file:
        assert (file.getnchannels(), file.getframerate()) == (1, 48000)
        assert file.getsampwidth() == bits // 8
        raw = np.frombuffer(file.readframes(file.getnframes()), np.uint8).reshape(-1, bits // 8)
    padded = np.zeros((len(raw), 4), np.uint8)
    padded[:, 4 - bits // 8 :] = raw
    values = padded.view("<i4")[:, 0] / 2**31
    # Rounding is half a step; the scale's top is one step short of 1, half of that at half scale;
    # float32 adds at most a quarter of a 24-bit step there.
    np.testing.assert_allclose(values, tone(), rtol=0, atol=1.26 * 2.0 ** (1 - bits))


def test_writing_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    write_wav(tmp_path / "a.wav", tone(), 48000)
    write_wav(tmp_path / "b.wav", tone(), 48000)
    assert (tmp_path / "a.wav").read_bytes() == (tmp_path / "b.wav").read_bytes()
    assert len(os.listdir(tmp_path)) == 2


@pytest.mark.parametrize(
    ("samples", "rate_hz", "bits", "named"),
    [
        ([0.0, 1.5], 48000, 16, "sample 2 is 1.5"),
        ([float("nan")], 48000, 16, "sample 1"),
        ([float("inf")], 48000, 16, "sample 1"),
        ([1e300], 48000, 16, "sample 1"),
        ([], 48000, 16, "samples"),
        ([[0.0], [0.0]], 48000, 16, "samples"),
        (["0.5"], 48000, 16, "samples"),
        ([0.0], 3, 16, "sample_rate_hz"),
        ([0.0], 48000, 17, "bits"),
    ],
)
def test_what_cannot_be_written(
    tmp_path: Path, samples: list[object], rate_hz: int, bits: int, named: str
) -> None:
    with pytest.raises(ifa.IfaValueError, match=named):
        write_wav(tmp_path / "out.wav", samples, rate_hz, bits)
    assert os.listdir(tmp_path) == []


def test_files_that_are_no_sound(tmp_path: Path) -> None:
    (tmp_path / "empty.wav").touch()
    (tmp_path / "text.wav").write_text("0.1\t0.1\n")
    for name in ("missing.wav", "empty.wav", "text.wav", ""):
        with pytest.raises(ifa.IfaFileError) as caught:
            read_sound(tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)
        assert isinstance(caught.value, OSError)
    with pytest.raises(ifa.IfaFileError, match="no file name"):
        read_sound("a\0b.wav")


def test_a_name_beyond_ascii(tmp_path: Path) -> None:
    path = tmp_path / "Würfel 骰子.wav"
    write_wav(path, [0.5], 48000)
    assert read_sound(path)[0].tolist() == [0.5]
    with pytest.raises(ifa.IfaFileError, match="骰子"):
        read_sound(tmp_path / "骰子.wav")


def test_random_bytes_give_our_errors_only(tmp_path: Path) -> None:
    random = np.random.default_rng(11)
    path = tmp_path / "a.wav"
    magic = [
        b"",
        b"RIFF\x24\0\0\0WAVEfmt ",
        b"fLaC\0\0\0\x22",
        b"OggS\0\x02",
        b"FORM\0\0\0\x20AIFF",
    ]
    failed = 0
    for round_ in range(200):
        path.write_bytes(magic[round_ % len(magic)] + random.bytes(int(random.integers(1, 300))))
        try:
            samples, _ = read_sound(path)
            assert len(samples) > 0
            assert np.isfinite(samples).all()
        except ifa.IfaFileError:
            failed += 1
    assert failed > 150  # nearly all are nonsense


@pytest.mark.skipif(not SOUNDS.is_dir(), reason="the recordings in ../shared/sounds are not here")
def test_recordings_read_as_the_standard_library_reads_them() -> None:
    paths = sorted(SOUNDS.glob("*.wav"))
    assert paths
    for path in paths:
        with wave.open(str(path), "rb") as file:
            assert file.getsampwidth() == 2
            frames = np.frombuffer(file.readframes(file.getnframes()), "<i2")
            frames = frames.reshape(-1, file.getnchannels())
            rate_hz = file.getframerate()
        samples, read_rate_hz = read_sound(path)
        assert read_rate_hz == rate_hz
        # averaging in float32 may round the last of its 24 bits
        np.testing.assert_allclose(samples, frames.mean(axis=1) / 32768, rtol=0, atol=2**-24)
