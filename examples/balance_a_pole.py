"""Balances a pole on a cart: reads joints, and pushes the cart, in each step."""
import lockstep

world = lockstep.World(
    {
        "settings": {"dt": 0.01, "integrator": "trapezoidal"},
        "bodies": [
            {"name": "cart", "mass": 1, "inertia": [0.1, 0.1, 0.1]},
            # a thin rod of 1 m, 0.1 kg, leaning by 0.1 rad
            {
                "name": "pole",
                "mass": 0.1,
                "inertia": [0.0083333333, 0.0083333333, 0.0001],
                "position": [0.049916708, 0, 0.49750208],
                "orientation": {"axis": [0, 1, 0], "angle": 0.1},
            },
        ],
        "joints": [
            {"name": "rail", "type": "slider", "bodies": ["world", "cart"], "anchor": [0, 0, 0], "axis": [1, 0, 0]},
            {"name": "tilt", "type": "hinge", "bodies": ["cart", "pole"], "anchor": [0, 0, 0], "axis": [0, 1, 0]},
        ],
    }
)
cart, rail, tilt = world.body("cart"), world.joint("rail"), world.joint("tilt")
for _ in range(2000):
    x, angle = world.joint_state(rail), world.joint_state(tilt)
    # the hinge counts from the lean of 0.1 rad that it was made with
    force = 40 * (angle.coordinate + 0.1) + 10 * angle.speed + 2 * x.coordinate + 4 * x.speed
    world.apply_force(cart, [force, 0, 0])
    world.step()
lean, travel = world.joint_state(tilt).coordinate + 0.1, world.joint_state(rail).coordinate
print(f"after {world.time:.0f} s the pole leans by {lean:.1e} rad, {travel:.1e} m from where it began")
assert abs(lean) < 1e-3 and abs(travel) < 1e-2, "the pole should stand"
