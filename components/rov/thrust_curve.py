"""The static curve of a thruster: thrust over command as a table, and its inverse; with dead band, jumps and saturation.

Commands of a table do not decrease; two rows of equal command are a jump, and at the jump the later row holds. Beyond the first
and the last row the thrust stays what it is there. A table with fewer rows than the arrays ends with its last row repeated.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel

ROWS = 16
COMMANDS_FALL, THRUSTS_FALL, ONE_SIDED = OWN + 1, OWN + 2, OWN + 3  # statuses
GRAVITY = 9.80665  # m/s², of the kilogram-force

# Pulse width in us and thrust in kgf at 16 V, of the maker's public sheet of the T200 (September 2019), as read in the
# repositories CentraleNantesROV/bluerov2 and ViktorNfa/bluerov2_dynamics. Between these rows the sheet's curve is taken as
# straight; its own rows stand 4 us apart, and from 1528 to 1532 us the thrust jumps by 0.4 N.
T200_PULSES = (1100, 1200, 1300, 1400, 1456, 1468, 1472, 1528, 1532, 1544, 1600, 1700, 1800, 1900)
T200_FORCES = (-4.069, -2.708, -1.438, -0.481, -0.086, -0.036, 0.0, 0.0, 0.041, 0.100, 0.603, 1.823, 3.420, 5.245)


def _filled(values: Sequence[float]) -> tuple[float, ...]:
    return (*values, *[values[-1]] * (ROWS - len(values)))


T200_COMMAND = _filled([(pulse - 1500) / 400 for pulse in T200_PULSES])
T200_THRUST = _filled([force * GRAVITY for force in T200_FORCES])  # N


def curve_refusals(effect: str) -> dict[int, Refusal]:
    """What `check_curve` refuses of the effect of a component that has the table in this effect."""
    return {
        COMMANDS_FALL: Refusal(
            f"{effect}: command[{{refused[0]}}] = {{refused[1]}}, command[{{refused[2]}}] = {{refused[3]}}",
            "values that do not decrease",
            "Repeat the last row where the table ends.",
        ),
        THRUSTS_FALL: Refusal(
            f"{effect}: thrust[{{refused[0]}}] = {{refused[1]}}, thrust[{{refused[2]}}] = {{refused[3]}}",
            "values that do not decrease",
            "Repeat the last row where the table ends.",
        ),
        ONE_SIDED: Refusal(
            f"{effect}: thrust from {{{effect}.thrust[1]}} to {{{effect}.thrust[{ROWS}]}} N",
            "a table from reverse to forward thrust",
        ),
    }


@kernel
def check_curve(commands, thrusts, refused):
    """Status of a table: commands or thrusts that decrease are refused, and thrust of one sign, which no command would stop.

    refused: (4,) numbers of the refusal.
    """
    if falls(commands, refused):
        return COMMANDS_FALL
    if falls(thrusts, refused):
        return THRUSTS_FALL
    if not (thrusts[0] < 0.0 and thrusts[thrusts.size - 1] > 0.0):
        return ONE_SIDED
    return DONE


@kernel
def falls(values, refused):
    """Whether values decrease; number and value of the first one that does so, and of the next, are then put into `refused`."""
    for i in range(values.size - 1):
        if values[i + 1] < values[i]:
            refused[0], refused[1], refused[2], refused[3] = i + 1, values[i], i + 2, values[i + 1]
            return True
    return False


@kernel
def curve_thrust(command, commands, thrusts):
    """Thrust at a command, N; commands, thrusts: (n,)."""
    n = commands.size
    if command >= commands[n - 1]:
        return thrusts[n - 1]
    if command < commands[0]:
        return thrusts[0]
    i = 1
    while commands[i] <= command:
        i += 1
    share = (command - commands[i - 1]) / (commands[i] - commands[i - 1])
    return thrusts[i - 1] + share * (thrusts[i] - thrusts[i - 1])


@kernel
def curve_command(thrust, commands, thrusts):
    """Command for a thrust in N: the end of the dead band that is nearer to what is wanted, and 0 for none."""
    n = commands.size
    if thrust == 0.0:
        return 0.0
    if thrust <= thrusts[0]:
        return commands[0]
    if thrust >= thrusts[n - 1]:
        i = n - 1
        while thrusts[i - 1] == thrusts[n - 1]:
            i -= 1
        return commands[i]
    i = 1
    if thrust > 0.0:
        while thrusts[i] < thrust:
            i += 1
    else:
        while thrusts[i] <= thrust:
            i += 1
    share = (thrust - thrusts[i - 1]) / (thrusts[i] - thrusts[i - 1])
    return commands[i - 1] + share * (commands[i] - commands[i - 1])
