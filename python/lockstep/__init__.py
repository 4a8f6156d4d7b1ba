"""Rigid bodies whose results are bitwise identical on GPU, CPU and a plain C++ reference.

    import lockstep
    world = lockstep.World.load("slide_to_roll")
    world.step(60)
    print(world.time, world.poses()[-1], world.state_hash())

SI units, z up, quaternions x y z w, the world frame unless it says otherwise. The same calls in the same order give the
same bits on every device. Whatever goes wrong is a lockstep.Error; an argument of the wrong type is a TypeError.
`python -m lockstep` is the program.
"""
from lockstep._lockstep import (
    Body,
    Device,
    Error,
    Event,
    Hit,
    Impact,
    Joint,
    JointState,
    Judgement,
    SensorReading,
    Snapshot,
    StepErrors,
    Unsolved,
    Verdict,
    World,
    devices,
    scenes,
    settings,
    solvers,
    __version__,
)

__all__ = [
    "Body",
    "Device",
    "Error",
    "Event",
    "Hit",
    "Impact",
    "Joint",
    "JointState",
    "Judgement",
    "SensorReading",
    "Snapshot",
    "StepErrors",
    "Unsolved",
    "Verdict",
    "World",
    "devices",
    "scenes",
    "settings",
    "solvers",
]
