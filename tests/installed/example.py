"""Images in, states out, with an installed tagtwist: example.py RECORDING."""
import sys

import numpy as np
import tagtwist

config = tagtwist.load_config()  # the course's camera and mat; or load_config("mine.yaml")

# Frame by frame, as from a camera.
window = tagtwist.SlidingWindow(config)
for t_ns, image in tagtwist.Recording(sys.argv[1]):
    state = window.add(t_ns, image)
    if state is None:
        print(f"{t_ns} ns: no state yet")

# The whole recording.
result = tagtwist.estimate(config, sys.argv[1])
off = np.linalg.norm(state.position - result.position[-1])
figures = tagtwist.compare(result)["optimised"]
print(f"{len(result)} frames, {1e3 * figures['position_rmse_m']:.2f} mm off the truth; "
      f"the window's last state {1e3 * off:.2f} mm off the batch's")
sys.exit(0 if figures["position_rmse_m"] < 1e-3 and off < 1e-3 else 1)
