"""Settings of an operator of a pipe robot over time: frequency and amplitude of the exciter, voltage of its motor."""

from __future__ import annotations

from typing import Any

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import output, parameter

FOREVER = 1e12  # s
BACK_TOO_EARLY = OWN + 1  # status


class ExciterProgram(StatelessComponent):
    """Frequency, amplitude and voltage that change along a straight line from start to end, and may go back the same way.

    Which of them is connected is the scene's choice: a force takes frequency and amplitude, a motor its voltage. It is slow
    where the robot settles within the time in which the frequency passes the width of the resonance. All of it is
    ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    """

    title = "Program of frequency, amplitude and voltage over time"
    system = "pipe_robot"
    default_stop = 60.0

    start_frequency = parameter(30.0, "rad/s", "angular frequency before the change", low=0.0)
    end_frequency = parameter(120.0, "rad/s", "angular frequency after it", low=0.0)
    start_amplitude = parameter(20.0, "N", "amplitude before the change")
    end_amplitude = parameter(20.0, "N", "amplitude after it")
    start_voltage = parameter(0.0, "V", "voltage before the change")
    end_voltage = parameter(24.0, "V", "voltage after it")
    start_time = parameter(0.0, "s", "time at which the change begins")
    duration = parameter(30.0, "s", "time that the change takes, and the way back", low=1e-9)
    return_time = parameter(FOREVER, "s", "time at which the way back begins; the start is never")

    frequency = output("rad/s", "angular frequency of the force", nominal=10.0)
    amplitude = output("N", "amplitude of the force", nominal=10.0)
    voltage = output("V", "voltage asked of the motor's amplifier", nominal=10.0)

    refusals = {
        BACK_TOO_EARLY: Refusal(
            "return_time = {return_time} s",
            "at least {end[0]} s, when the change ends",
            "Begin the way back later, or shorten duration.",
        )
    }

    def shapes(self) -> dict[str, Any]:
        """`end`: (1,) time at which the change ends, s."""
        return {"end": 1}


OUT = ExciterProgram.output_places()


@kernel
def program_start(t, s, p, e):
    """The way back may not begin before the change has ended."""
    s.end[0] = p.start_time + p.duration
    return BACK_TOO_EARLY if p.return_time < s.end[0] else DONE


@kernel
def share_of_change(t, start, duration, back):
    """0 before the change, 1 after it, and 0 again after the way back."""
    return min(max((t - start) / duration, 0.0), 1.0) - min(max((t - back) / duration, 0.0), 1.0)


@kernel
def program_outputs(t, s, p, e):
    """Frequency, amplitude and voltage at a time."""
    share, y = share_of_change(t, p.start_time, p.duration, p.return_time), s.y
    y[OUT.frequency] = p.start_frequency + share * (p.end_frequency - p.start_frequency)
    y[OUT.amplitude] = p.start_amplitude + share * (p.end_amplitude - p.start_amplitude)
    y[OUT.voltage] = p.start_voltage + share * (p.end_voltage - p.start_voltage)
    return DONE


ExciterProgram.kernels = stateless_kernels(__name__, program_outputs, program_start)
