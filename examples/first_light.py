"""From a sound to a motion and back: makes a recording, marks it, solves it, checks and draws it.

    python examples/first_light.py [FOLDER]          (build/demo if left out)

A simulated die is thrown on a table. What its hits sound like becomes a recording, and the times of
those hits become marks. From here on the throw is forgotten: the solver sees only the marks and the
recording, finds a motion of its own, and the verifier checks that motion from its poses alone.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import ifa
import numpy as np
from ifa.plot import plot_solution, plot_strobe
from ifa.simulation import Hits
from ifa.sound import write_wav

HERE = Path(__file__).resolve().parent
SAMPLE_RATE_HZ = 48_000
FIRST_HIT_S = 0.2  # of silence before the die lands
AUDIBLE_SPEED_M_S = 0.05
MERGE_GAP_S = 0.010
BLENDER_LIMIT_S = 120

# Ringing of a die and a table top: frequency in Hz, decay time in s, share of the loudness.
DIE_MODES = ((2350.0, 0.011, 0.9), (3720.0, 0.009, 0.7), (5480.0, 0.007, 0.5), (8210.0, 0.004, 0.4))
TABLE_MODES = ((142.0, 0.060, 0.35), (231.0, 0.045, 0.45), (388.0, 0.032, 0.4), (702.0, 0.020, 0.3))


def throw_die(body: ifa.Body) -> ifa.Run:
    """A low throw, spinning, from just above the table to rest."""
    state = ifa.State(
        position_m=[0.0, 0.0, 0.06],
        quaternion_wxyz=[0.5, 0.6, -0.2, 0.4],
        velocity_m_s=[0.55, 0.1, -0.9],
        angular_velocity_rad_s=[4.0, 16.0, -3.0],
    )
    return ifa.simulate(body, state)


def audible_events(hits: Hits) -> list[np.ndarray]:
    """Times of the hits that can be heard, those less than 10 ms after another in one group."""
    times_s = hits.time_s[hits.approach_speed_m_s > AUDIBLE_SPEED_M_S]
    return np.split(times_s, np.flatnonzero(np.diff(times_s) >= MERGE_GAP_S) + 1)


def synthesise(hits: Hits, shift_s: float, length_s: float) -> np.ndarray:
    """What the hits sound like: damped modes as loud as the impulse, and a soft room."""
    time_s = np.arange(round(length_s * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    sound = np.zeros_like(time_s)
    random = np.random.default_rng(1)
    audible = hits.approach_speed_m_s > AUDIBLE_SPEED_M_S
    loudness = np.linalg.norm(hits.impulse_n_s, axis=1)
    for hit_s, loud in zip(hits.time_s[audible] + shift_s, loudness[audible], strict=True):
        after = time_s >= hit_s
        t = time_s[after] - hit_s
        for frequency_hz, decay_s, share in DIE_MODES + TABLE_MODES:
            # where on the die it strikes changes how much of each mode is heard
            amount = loud * share * random.uniform(0.7, 1.0)
            sound[after] += amount * np.sin(2 * np.pi * frequency_hz * t) * np.exp(-t / decay_s)
    room_s = np.arange(round(0.25 * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    room = random.normal(size=len(room_s)) * np.exp(-room_s / 0.06)
    room = np.convolve(room, np.hanning(24) / 12.0, mode="same")
    size = len(sound) + len(room) - 1
    echo = np.fft.irfft(np.fft.rfft(sound, size) * np.fft.rfft(room, size), size)[: len(sound)]
    sound = sound / np.abs(sound).max() + 0.04 * echo / np.abs(echo).max()
    return 0.8 * sound / np.abs(sound).max()


def write_labels(path: Path, events: list[np.ndarray], shift_s: float) -> None:
    """An Audacity label track: a point for a click, a span for a rattle."""
    rows = []
    for number, times_s in enumerate(events, start=1):
        start_s = times_s[0] + shift_s
        end_s = times_s[-1] + shift_s
        if end_s - start_s < MERGE_GAP_S:
            end_s = start_s
        rows.append(f"{start_s:.6f}\t{end_s:.6f}\thit {number}\n")
    path.write_text("".join(rows), encoding="utf-8")


def write_blend(folder: Path) -> str:
    """Key the motion in Blender, if there is one. Returns one line about it."""
    blender = shutil.which("blender")
    if blender is None:
        return "no .blend: there is no blender on the PATH"
    environment = dict(os.environ)
    for name in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"):
        environment.pop(name, None)
    # Debian's Blender takes its standard library from the first python3 on the PATH
    environment["PATH"] = os.pathsep.join(["/usr/bin", "/bin", environment.get("PATH", "")])
    environment["IFA_PYTHONPATH"] = str(Path(ifa.__file__).absolute().parents[1])
    command = [blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "3"]
    command += ["--python", str(HERE / "first_light_blend.py"), "--", str(folder.resolve())]
    log = folder / "blender.log"
    try:
        with log.open("w", encoding="utf-8") as file:
            done = subprocess.run(
                command, env=environment, stdout=file, stderr=file, timeout=BLENDER_LIMIT_S
            )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"no .blend: {error}"
    if done.returncode:
        return f"no .blend: Blender could not key the motion, see {log}"
    log.unlink()
    return "a die with keys, the sound strip and a marker on each contact"


def main() -> int:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "build" / "demo"
    folder.mkdir(parents=True, exist_ok=True)
    begin_s = time.perf_counter()

    def report(name: str, text: str) -> None:
        print(f"{folder / name!s:32} {text}", flush=True)

    body = ifa.bodies.get("d6", surface="wood")
    thrown = throw_die(body)
    events = audible_events(thrown.hits)
    shift_s = FIRST_HIT_S - events[0][0]
    length_s = events[-1][-1] + shift_s + 0.45
    write_wav(folder / "roll.wav", synthesise(thrown.hits, shift_s, length_s), SAMPLE_RATE_HZ)
    report("roll.wav", f"{length_s:.2f} s, the clicks of a simulated {body.name}")
    write_labels(folder / "roll.txt", events, shift_s)
    report("roll.txt", f"{len(events)} marks, as an Audacity label track")

    # From here on only the recording and its marks count.
    marks = ifa.Signature.read(folder / "roll.txt", sound=folder / "roll.wav")
    solution = ifa.solve(body, marks)
    solution.write(folder / "motion.json")
    retime = max(abs(event.retime - 1.0) for event in solution.events)
    excess = max(event.excess for event in solution.events)
    report(
        "motion.json",
        f"{'succeeded' if solution.succeeded else 'NOT succeeded'}, "
        f"{'plausible' if solution.plausible else 'not plausible'}, score {solution.score:.2f}, "
        f"{solution.solve_s:.1f} s",
    )
    certificate = ifa.verify(folder / "motion.json", body, marks)
    text = json.dumps(certificate.to_dict(), indent=1) + "\n"
    (folder / "certificate.json").write_text(text, encoding="utf-8")
    report(
        "certificate.json",
        f"{'passed' if certificate.passed else 'FAILED'}: {len(marks) - certificate.missed_hits} "
        f"of {len(marks)} marks met, {certificate.extra_hits} extra hits",
    )
    plot_solution(solution, folder / "roll.wav", folder / "signature.png")
    report("signature.png", "waveform, marks, achieved hits, every factor")
    plot_strobe(solution, folder / "strobe.png")
    report("strobe.png", "the motion from the side at 60 frames a second")
    report("first_light.blend", write_blend(folder))

    print(
        f"\nworst error {1e3 * solution.max_abs_error_s:.3f} ms (verifier: "
        f"{1e3 * certificate.max_abs_error_s:.3f} ms), largest retiming {100 * retime:.2f} %, "
        f"largest excess {excess:.2f} of 1,\npenetration {1e3 * certificate.max_penetration_m:.4f} "
        f"mm; {time.perf_counter() - begin_s:.1f} s in all"
    )
    for failure in certificate.failures:
        print(f"verifier: {failure}")
    return 0 if solution.succeeded and certificate.passed else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except ifa.IfaError as error:
        sys.exit(f"first_light: {error}")
