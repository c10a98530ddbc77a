"""The example of the README."""

import numpy as np

import ifa

body = ifa.bodies.get("d6", surface="wood")
marks = ifa.Signature([0.10, 0.245, 0.34, 0.40, 0.445])  # when the contacts are heard, in s
solution = ifa.solve(body, marks, material="fit")
print(f"score {solution.score:.2f}, succeeded: {solution.succeeded}")
for event in solution.events:
    print(f"mark {event.target_s:.3f} s, hit {event.achieved_s:.3f} s, retimed {event.retime:.3f}")
frames_s = np.arange(solution.motion.start_s, solution.motion.end_s, 1 / 24)
positions_m, quaternions_wxyz = solution.motion.sample(frames_s)  # (n, 3), (n, 4)
solution.write("motion.json")
print(ifa.verify("motion.json", body, marks).summary())
