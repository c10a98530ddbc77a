"""Print docs/hard_cases.md's table from what the hard cases printed: ctest -V | table.py"""

import re
import sys

EXPECTED = {
    1: "Jacobi's closed form of a tri-axial rotation",
    2: "flip period 4 K(k) / rate; energy and momentum kept",
    3: "precession L / I1, body rate (I3 - I1) w3 / I1",
    4: "elliptic modulus 1 - 1e-12 and 1: finite, momentum kept",
    5: "forward, then reversed: the identity",
    7: "the quadratic's root; with spin: no vertex below the ground before, one on it",
    8: "impact N at sqrt(2h/g) (1 + 2 sum e^k), rest near the limit",
    9: "v+ = e v, no spin: flat, on an edge, on a corner",
    10: "J = m (1 + e) v / (1 + 3 cos^2 t), w+ = 6 J cos t / (m l)",
    11: "energy never grows; e = 1 and mu = 0 keep it; 1e6 impacts",
    12: "stops after v^2 / (2 mu g) on its heading, 64 headings",
    13: "5/7 v0 after 2 v0 / (7 mu g), 2/3 v0 after v0 / (3 mu g)",
    14: "tips from tan a = w / h on, slides from tan a = mu on",
    15: "Painleve rod, mu > 4/3: an impulse, finite, no energy gained",
    16: "Euler's disk: W^2 sin a = 4 g / R; a coin on its edge keeps its speed; first contact",
    18: "none of 1e6 thin plates at 40 m/s falls through",
    19: "moments 1 : 1e12 and 0, 1e6 random bodies: finite, or an error that names the field",
    20: "size x 4^k, mass x 2^k: the same bits",
    21: "any yaw: the same motion, turned",
    22: "quaternion log: round trip, shortest arc, the same for q and -q",
    23: "shooting, error 0 to pi, 1 ms to 0.5 s, needles and cards: converges, or says why",
    25: "1e5 impacts: ends, or stops at the limit; a rimless wheel at McGeer's speed",
    26: "one mark, 1 us apart, 500, a 60 s pause, out of order, NaN: solved, or an error naming it",
}
HELD = re.compile(r"\[ +held +\] (\S+) \| (.+) \| asked (\S+) \| held (\S+)")
RESULT = re.compile(r"Test +#\d+: (?:hard_cases|base)\.(\S+) \.+ *(?:\*+)? *(Passed|Failed|\S+)")


def case_of(test: str) -> int:
    number = re.search(r"HardCase(\d+)", test)
    return int(number[1]) if number else 22 if "RotationLog" in test else 1


def main() -> int:
    rows: dict[tuple[str, str], tuple[str, float]] = {}
    failed: dict[str, bool] = {}
    for line in sys.stdin:
        if held := HELD.search(line):
            test = re.sub(r"^\w+/|/\d+$", "", held[1])  # shards of a test are one row
            asked, worst = rows.get((test, held[2]), (held[3], 0.0))
            rows[test, held[2]] = asked, max(worst, float(held[4]))
        elif result := RESULT.search(line):
            test = re.sub(r"^\w+/|/\d+$", "", result[1])
            failed[test] = failed.get(test, False) or result[2] != "Passed"
    measured = {test for test, _ in rows}
    for test in failed:
        if test not in measured:
            rows[test, "exact"] = "-", 0.0
    print("| case | expected | measured | asked | held | test |\n|---|---|---|---|---|---|")
    told = set()
    for (test, quantity), (asked, worst) in sorted(
        rows.items(), key=lambda row: (case_of(row[0][0]), row[0])
    ):
        case = case_of(test)
        expected = "" if case in told else EXPECTED[case]
        told.add(case)
        if asked == "-":
            held_text = "no" if failed[test] else "yes"
        else:
            held_text = f"{worst:.1e}" if worst <= float(asked) else f"**{worst:.1e}**"
        print(f"| {case} | {expected} | {quantity} | {asked} | {held_text} | {test} |")
    for test in sorted(test for test in failed if failed[test]):
        print(f"failed: {test}", file=sys.stderr)
    return int(any(failed.values()) or not rows)


if __name__ == "__main__":
    sys.exit(main())
