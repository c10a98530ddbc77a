"""The example of the README."""

import ifa
import numpy as np

body = ifa.bodies.get("d6", surface="wood")
marks = ifa.Signature([0.30, 0.41, 0.48, 0.53, 0.565, 0.59])  # when contacts are heard, s
solution = ifa.solve(body, marks)
print(f"score {solution.score:.2f}, succeeded: {solution.succeeded}")
for event in solution.events:
    print(f"mark {event.target_s:.3f} s, hit {event.achieved_s:.3f} s, retimed {event.retime:.3f}")
frames_s = np.arange(solution.motion.start_s, solution.motion.end_s, 1 / 24)
positions_m, quaternions_wxyz = solution.motion.sample(frames_s)  # (n, 3), (n, 4)
solution.write("motion.json")
print(ifa.verify("motion.json", body, marks).summary())
