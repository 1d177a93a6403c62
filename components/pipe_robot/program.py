"""What an operator of a pipe robot sets over time: frequency and amplitude of the exciter, voltage of its motor."""

from __future__ import annotations

from ..core.errors import BadInput
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent
from ..core.variables import output, parameter

FOREVER = 1e12  # s


class ExciterProgram(StatelessComponent):
    """Frequency, amplitude and voltage that change along a straight line from start to end, and may go back the same way.

    Which of them is connected is the scene's choice: a force takes frequency and amplitude, a motor its voltage. It is slow
    where the robot settles within the time in which the frequency passes the width of the resonance. All of it is
    ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    """

    title = "Program of frequency, amplitude and voltage over time"
    system = "pipe_robot"
    start_inputs = ()
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

    def _initialize(self, t: float) -> int:
        end = self.get("start_time") + self.get("duration")
        if self.get("return_time") < end:
            raise BadInput(self.name, f"return_time = {self.get('return_time'):g} s", f"at least {end:g} s, when the change ends",
                           "Begin the way back later, or shorten duration.")
        self.arguments = self._declared_arguments()
        return DONE

    def _outputs(self, t: float) -> None:
        p = self.arguments[0]
        share = share_of_change(t, p.start_time, p.duration, p.return_time)
        self.y[0] = p.start_frequency + share * (p.end_frequency - p.start_frequency)
        self.y[1] = p.start_amplitude + share * (p.end_amplitude - p.start_amplitude)
        self.y[2] = p.start_voltage + share * (p.end_voltage - p.start_voltage)


@kernel
def share_of_change(t, start, duration, back):
    """0 before the change, 1 after it, and 0 again after the way back."""
    return min(max((t - start) / duration, 0.0), 1.0) - min(max((t - back) / duration, 0.0), 1.0)
