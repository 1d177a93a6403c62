"""The thresholds from which the numbers of a run are doubted, each with its reason; how motions are sampled stands with the sampling."""

from __future__ import annotations

# -- numerical errors, as shares of a signal's scale, see `comparison.scale_of` ----------------------------------------------
WARN = 0.05  # error from which a run warns: a twentieth of a signal's deviation is seen in its curve
AIM = 0.01  # error that the suggested step is for: less is not seen in a curve
ORDER_UNSURE = 0.02  # difference from which a third run is made: below it, twice the difference bounds an error of first order
HARDLY = 1e-3  # deviation over rms below which a signal is judged by its size: it stands still, as a conserved quantity does
MESH_ORDERS = (0.5, 1.0)  # between which the order of a mesh is taken: coarse meshes show higher ones than the finer ones have
UNSEEN = 0.5  # departure from a straight line between two rows from which rows do not show a signal; one that jumps has a third
FEWEST_ROWS = 10  # that tell how a signal goes on between two
NO_MATTER = 5e-3  # of a figure: what the ends of a run make of it may stay in its error
NOTHING = 1e-6  # of a signal's nominal value: what is smaller counts as nothing, as a momentum that is conserved at 0

# -- parameter errors, in `parameter_errors` -----------------------------------------------------------------------------------
SECOND_ORDER = (
    0.2  # of a figure's standard deviation, left out by first order, from which a run warns: a fifth shows in its digits
)
PARAMETER_SAMPLES = 6  # pairs on either side, which tell curvature from slope

# -- budget ------------------------------------------------------------------------------------------------------------------
BUDGET = 5e8  # counted work, see `work`, that repetitions of a run may take without being asked for: some 5 s of one core
BUDGETS_OF_CASE = 2.0  # that a case may take, which has several runs
WINDOWS = 4  # of a run that is too long to repeat: the begin, two places within and the end
WINDOWS_PLACES = 50  # where a window may begin: half of one, which is what is judged of it, is as long as from one to the next
WINDOWS_SHARE = 0.5  # of the run's own cost that windows may take together
PROBED = 0.02  # of a run that is made to count the work of the whole, and in a dry run to see how large errors are
PROBED_STEPS = 16  # macro steps of it at least to count the work
PREFIX_STEPS = 400  # macro steps of it at least in a dry run: motions begin
PREFIX_WORK = 6.0 * BUDGET  # that they may take in a dry run, which is to answer at once

MOSTLY = (
    0.75  # share of an error that half the macro step alone shows, from which the error is its own; below the rest, it is inside
)

# -- what kind of difference it is ---------------------------------------------------------------------------------------------
SECTIONS = 256  # of a run, whose differences are compared
TOGETHER = 0.05  # largest difference in the first sections of a run whose histories part later
LATER = (
    1.6  # factor by which runs of half the steps stay together longer at most where they part: what drifts stays twice as long
)
APART = 0.3  # difference in the last part from which histories have parted
SAME_SPREAD = 1.25  # factor that deviations of runs may differ by whose histories part while their statistics agree
FEW = 0.01  # of the rows, in which BULK of a squared difference is where a signal jumps at another instant
BULK = 0.9
CONVERGING = 1.5  # factor by which differences fall with half the step, from which runs converge; first order has 2
LOWEST_ORDER = 0.5  # below it a shorter step is no remedy: for a tenth of an error it would have to be a hundredth
GROWN = 3.0  # deviation over that of the finest run from which the coupling makes a motion of its own: it is unstable
LASTING = 2.0  # range in the last half of a run over that of the whole finest run, from which a motion of the coupling's own does
# not decay. Computed: of a mass on a spring at 0.9 and 0.98 of its limits (six dampings, degrees 0 to 2, 6 to 2000 steps) at most 1.84
GROWING = 1.2  # factor from the third to the last quarter of a window from which a difference grows on: evenly, it would be 1.4
NEGLIGIBLE = 1e-6  # of a signal's scale: a difference below it is rounding and what an iteration leaves
UNRELATED = 2.0**0.5  # difference of two histories of the same deviation that have nothing to do with one another
LOST = 1.0  # error from which such a signal tells nothing

# -- while a run goes on -------------------------------------------------------------------------------------------------------
RISE = 1.5  # growth of a miss from block to block, in BLOCKS blocks: an instability grows in every one, a disturbance does not
BLOCKS = 5
MISSED = 0.1  # miss over the value: from there an extrapolation does not follow
BEYOND = 300.0  # of an interface's scale, which is its nominal value or what it reached before; a resonance gives 50
OVERSHOT = 1.0  # miss over the value, from which it comes on the other side: held inputs miss what grows by itself by less
UNFOLLOWED = 1.0  # rms miss of an input over its deviation, from which its mean would foretell it better. Measured in the first
# 3000 macro steps, or all there are: rotor-bearings-heat 0.79, the other 35 shipped scenes that lead inputs at most 0.29 (without
# lumped-catenary); en50318-2002 with steps of 5, 10, 20 ms 0.29, 1.6, 3.1
ENERGY = 0.1  # of the energy exchanged at a bond that the coupling makes: amplitudes are off by several per cent

# -- whether the coupling lets disturbances grow, in `stability` ---------------------------------------------------------------
SAME_MAP = 1e-6  # relative difference of the derivatives of a macro step at two instants that are one
AT_REST = 1e-5  # distance from 1 of the eigenvalues of a free body, which come in pairs: rounding parts them by 1e-8 and more
# growth in a run, as a logarithm, that it may show by chance; where a push grows in every part of it, `GROWN` is enough
EXCESS = 5.0
FASTER = 1.5  # times the rate at which disturbances grow by themselves: more is not their own doing

# -- what rows leave of a figure, in `sampling` --------------------------------------------------------------------------------
BETWEEN = (3, 5)  # rows that one becomes: largest values are then off by a 25th; a length may be a multiple of one, not of two
MOST_VALUES = 20_000_000  # that filled up rows may have: 160 MB
PARTS = 8  # of a run whose figures are means over one of many histories
PARTS_SURE = 2.4  # deviations of such a mean that hold 95 % of them: Student's t of 7 degrees of freedom, 2.36
