"""`python -m lockstep`, and the command `lockstep` of the wheel: the program, which lies beside the module."""
import os
import pathlib
import sys


def main() -> None:
    program = pathlib.Path(__file__).parent / "bin" / "lockstep"
    if not program.is_file():
        sys.exit(f"lockstep: {program} is missing; install Lockstep by `pip install .`, or build the target lockstep_app")
    os.execv(program, ["lockstep", *sys.argv[1:]])


if __name__ == "__main__":
    main()
