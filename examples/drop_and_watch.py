"""Stacks boxes in a scene made in Python, and asks how they stand and how well that was computed."""
import lockstep
import numpy as np

rng = np.random.default_rng(1)
box = {"density": 500, "shapes": [{"type": "box", "size": [0.3, 0.3, 0.3]}]}
world = lockstep.World(
    {
        "settings": {"dt": 1 / 60, "solver": "small_steps", "substeps": 5},
        "bodies": [{"name": "ground", "type": "static", "shapes": [{"type": "plane"}]}]
        + [{**box, "position": [*rng.uniform(-0.02, 0.02, 2), 0.2 + 0.35 * i]} for i in range(10)],
    }
)
world.step(300)

print(f"after {world.time:.1f} s the boxes are {np.round(world.poses()[1:, 2], 3)} m high")
force = -world.contact_force(world.body("ground"))[2]
weight = sum(world.mass(body) for body in world.bodies) * 9.81
print(f"the ground carries {force:.1f} N of a weight of {weight:.1f} N")
errors = world.errors()
print(f"overlap {errors.max_penetration:.1e} m, residual {errors.residual:.1e}")
print(f"state {world.state_hash()} on {world.device.name}")
assert abs(force - weight) < 0.01 * weight, "the ground should carry the boxes"
