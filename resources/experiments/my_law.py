# A law of one's own in ten lines: every robot steers towards its reference.   skein run python_law.toml
import numpy as np
import skein.controller

@skein.controller.law(k=(2.0, "1/s", 0.0, 20.0, "how fast the error ahead is corrected"),
                      turn=(8.0, "rad/(m s)", 0.0, 50.0, "steering towards the reference"), logs=["distance"])
def step(tick):
    x, y, theta = tick.error.T
    tick.v[:] = tick.reference[:, 3] * np.cos(theta) + tick.parameters["k"] * x
    tick.omega[:] = tick.reference[:, 4] + 3.0 * np.sin(theta) + tick.parameters["turn"] * y
    tick.log["distance"][:] = np.hypot(x, y)

skein.controller.run(step)
