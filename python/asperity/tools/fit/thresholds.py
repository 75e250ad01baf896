"""Numbers by which a fit decides: what each of them decides and why it has this value.

Effects, where they were measured, are those on the drawn sets of `harness.studies.fits`, seed 20610.
"""

from __future__ import annotations

# what is a result

GOOD, FAIR = 0.05, 0.15
"""Largest error of a good and of a fair fit.  A poor one is no result."""

UNSAFE = 0.1
"""Largest error of a peak of the law that is too high, which is not on the safe side."""

FLOOR = 0.1
"""Least residual strength, over the peak, that an error is relative to: a bond that ends at 0 has no relative
error.
"""

BY_NOISE = 2.0
"""Standard deviations of a measured number within which an error is noise, and of the rows within which the
fall of a bond is.
"""

FACTOR = 2.0
"""Factor from the middle of an interval to its ends beyond which a constant is not determined.  All of 90
drawn Gc of results and 5 W0 of cycles lie within it.
"""

BOUND_DISTANCE = 1.0e-3
"""Distance from a bound of what is plausible, over its range, up to which a constant lies at the bound."""

MISSED_BACK, TIMES_MISSED = 0.05, 1.5
"""Error of the unloading of closure tests, and that over the error of the loading, beyond which a note says
that an elastic contact keeps no closure.
"""

BEYOND = 1.01
"""Ratio of a pressure or slip to those of the tests of a fit above which it lies beyond them."""

NO_WIDTH = 1.0e-9
"""Relative width of an interval that has none, as that of computed or copied numbers."""

# rows that are needed

LEAST_ROWS, ROWS_OF_ONE = 10, 20
"""Rows with which a law can be judged; and of a single curve beside whose noise a misfit is seen.  Without
both, one of 42 sets of nonsense is a result.
"""

SLIDING = 0.05
"""Slip beyond the spring, over the largest slip, of a row that slides.  With 0 one of 42 sets of nonsense, an
elastic line, is a result.
"""

SHARE_SLIDING = 0.1
"""Least fraction of rows of a test that slide, as a test that ends before sliding shows no strength."""

SLIDING_ROWS = 3
"""Least number of such rows: without it one row of ten below an elastic line is a strength."""

ROWS_EACH = 3
"""Rows, and independent data, for each constant."""

LEAST_TESTS, LEAST_REPLICATES = 3, 2
"""Strengths that a fit needs, as the ISRM asks for three peaks; and degrees of freedom of replicates that
show their own spread.
"""

LEAST_LOADING = 6
"""Rows of loading that closure tests need together, ROWS_EACH for each of kn and closure."""

PARTS_OF_CLOSURE = 5
"""Parts of the loading that are left out one by one for the intervals of a closure."""

MANY_CLOSURES = 3
"""Number of tests beyond which whole tests are left out, too: four leave two degrees of freedom beside two
constants.
"""

# files

ROWS_OF_TEST = 5
"""Rows of a test: fewer show no stiffness, peak or residual strength."""

ROWS_OF_CURVE = 10
"""Rows of a table of strengths at one pressure from which on growing slips are those of a curve."""

CLEARLY = 1.5
"""Ratio of the larger of compression and tension of a table to the smaller one, from which on the larger one
is the compression: either sign may be that of compression.
"""

LEAP = 3.0
"""Jump of the slip over the usual step beyond which the next test may begin."""

RETURN = 0.3
"""Jump of the slip over the way so far beyond which the slip has gone back to the start of the next test."""

LEAST_WAY = 0.1
"""Way of a test over the range of the slip of the file beyond which the next test may begin."""

REVERSED = -0.1
"""Smallest tau over the largest one with which the next test begins, because a joint that slips back in a
cycle has reversed tau.
"""

RESTING = 0.5
"""Traction over the largest one below which a joint rests in the first row; from it on a late slip is an
error, as the start is not known.  Also the share of the dilation in the first rows from which on they are too
far apart to lead to the start.
"""

SURELY = 0.25
"""Traction over the largest one below which a joint rests without any dilation, so that an offset is seen."""

LATE = 4.0
"""Slip of a first row over the usual step beyond which it is late; half of it for a surely resting joint."""

PART = 0.05
"""Slip or dilation of a first row over its range beyond which it is late."""

BEYOND_NOISE = 4.0
"""Standard deviations of the noise that an offset of the dilation exceeds, as one of 16000 numbers does; and
that the lift of asperities exceeds where a dilation that is noise excludes it: neighbouring rows of such a
lift have a correlation of 0.57, above SIGNAL.
"""

LEAST_NOISE = 6
"""Number of rows beyond which second differences of the dilation show its noise; else it counts as 0."""

FIRST_ROWS = 8
"""First rows whose slope or parabola leads to the dilation at the start."""

UNLOADED = 0.5
"""Traction over that at the largest slip so far below which the joint was unloaded."""

OF_CYCLE = 0.05
"""Reversed traction over the largest one from which on rows belong to a cycle, and not to an unloading; and
fall of the traction that is none without one.
"""

ELASTIC = 0.1
"""Return of the slip over its range that is more than elastic, so that it is no unloading."""

# checks of tests

FAR = 0.98
"""Slip over the largest one that counts as it."""

HELD = 0.05
"""Largest relative variation of a constant normal traction."""

LEAST_CORRELATION, TIMES = 0.95, 1.5
"""Correlation of pressure and dilation in a box with a normal stiffness; and ratio of the given stiffness to
that of the rows above which they contradict each other.
"""

LARGEST_RATIO, LARGEST_FRICTION = 1.0e3, 100.0
"""Ratios of two lengths or stresses above which units are mixed (kPa to MPa is near 1000), and of tau to
|sigma_N| without units (a friction of 0.8 on planes of 45 degrees gives 9).
"""

LEAST_FRICTION = 0.15
"""Median ratio of peaks to pressures of a table below which one of them may be in another unit: clay and
graphite have 8.5 degrees, joints of rock, concrete and masonry 20 degrees and more.
"""

STEEPEST, OFFSET = 20.0, 0.5
"""Ratio of dilation to slip of planes of 87 degrees; largest first dilation or slip over its range."""

CLOSING = 0.05
"""Closure over the slip at the end of a test beyond which its sign may be the other one."""

SIGNAL, OF_SIGNAL = 0.25, 3.0
"""Largest correlation of neighbouring rows, and this in standard deviations of that of independent ones, of a
dilation that is noise.
"""

LONELY = 3.0
"""Distance of a dilation from all others, over their range, of an outlier: one in 800 columns of ten rows of
noise has one.
"""

SAME_ROWS, SAME_DIGITS = 0.9, 6
"""Fraction of the rows of a test in another one that makes it a copy, and digits in which they agree."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals."""

MARK = 10.0
"""Size of -999, 9999 and the like over the range of the other numbers of a column, with 0, from which on they
are marks of missing values.
"""

FALL = 0.02
"""Fall of the pressure, over its range, that ends the loading, and rise that ends the unloading."""

# choice of a model

GAIN, GAIN_OF_STRENGTHS = 6.0, 4.0
"""Information criterion (BIC) that a further constant or another shape must gain: strong evidence (Kass and
Raftery 1995); and of a table of strengths, whose numbers are few: with 6 four peaks with residual strengths
whose ratio to the pressure falls are no result.
"""

LEAST_DATA, MOST_ALIKE = 4.0, 0.98
"""Least number of independent data of a curve, and largest correlation of its neighbouring residuals."""

NOISE, ROWS_OF_NOISE = 0.6, 20
"""Independent data, over all, of residuals that are noise, so that no larger model is tried; and rows of the
shortest test beyond which that can be told.
"""

MOVED = 1.0
"""Change of the logarithm of a sum of squares, times its rows, below which noise hides what tells two forms
apart: a constant that is moved by its standard deviation changes it by one.
"""

APART = 1.5
"""Ratio of two pressures that show the crushing of asperities."""

ROOT = 0.5
"""Exponent of the pressure with which the strength that asperities add to the friction grows at least: Barton
and Choubey give 0.6 to 0.8, asperities that are not crushed 1, a bond 0.
"""

# intervals

CONFIDENCE, NORMAL = 0.95, 1.959964
"""Of the intervals; and quantile of the normal distribution for it."""

PARTS, RIDGE = 8, 1.0e-3
"""Parts of a curve that are left out one by one; and share of the information that remains of a constant
that a single part shows.
"""

SCATTER, SCATTER_OF_OTHERS, KNOWN_TESTS = {"mu": 0.07}, 0.15, 2.0
"""Relative standard deviation of a constant of specimens of one joint, that of constants without own one, and
the degrees of freedom that they count for.  Triplets of 15 kinds of masonry scatter by 14.5 % on average
(Danish Building Research Institute), residual strengths of sandstone joints by 1 to 5 %.
"""

# reading of curves

SMOOTHED = 0.05
"""Fraction of the rows over which a curve is averaged before its peak is read, as the largest of noisy rows
is above the peak.
"""

AT_END = 0.1
"""Fraction of the rows at the end of a test of which the residual strength and dilation are the means."""

BACK = 0.02
"""Return of the slip over its range that ends a stroke, or unloads it where tau falls without being reversed:
a smaller one may be noise of the gauge.
"""

LEVELS_APART = 1.2
"""Ratio of the largest to the smallest pressure from which on tests show what depends on it: below it they
have one pressure, but for its scatter.
"""

FALLS = 0.95
"""Strength over pressure at the largest pressure, over that at the smallest, below which a weight may have
been left out of the pressure.
"""

WEIGHT = 0.1
"""Pressure that is missing over the smallest one beyond which a weight may have been left out."""

ENDED = 0.3
"""Slope of the dilation at the end over the largest one above which it has not ended, as a note says."""

WEIGHTS, LEAST_RANGE = (0.2, 5.0), 0.05
"""Smallest and largest weight of the dilation, by which it has the scatter of the strength; and smallest
scale of the dilation of a test, over the largest dilation of all tests, as one with less shows mostly noise.
"""

# closure tests

LARGEST_CLOSURES, STIFFNESSES = (1.0, 50.0), (1e-2, 1e3)
"""Ranges of the largest closure over the measured one, and of the stiffness over pressure per closure."""

# what counts as rigid

STIFF, STIFF_CONTACT = 1.0e3, 20.0
"""Stiffness of a joint or spring that counts as rigid, over stress/length of the tests; kc of a rigid
contact.
"""

BRITTLE, RIGID_BOND = 0.999, 0.99
"""eta of a bond beside which friction acts from the first slip on; and the least that has the closed form."""

SOFT_CYCLES = 1.0e2
"""Largest ks in cycles over stress/length, where a stiffer joint takes too many increments."""

# search

AROUND, REACH_OF_OTHERS = 6, 0.3
REACH = {"ks": 1.2, "kT": 1.2, "mu": 0.15, "sigma0": 0.5, "Gc": 1.2, "crush": 1.2, "W0": 1.2}
REACH |= {"height": 0.4, "eta": 0.0}
"""Points around a start, and their distance from it, on a logarithm: how far a guess may be off."""

STEP = 1.0e-3
"""Step of the differences of curves, which are interpolated; with 1e-4 no row of strengths changes."""

SEARCHED, FITTED = 1.0e-4, 1.0e-7
"""Relative change of the sum of squares at which a search and fits beside the chosen one end, and the fit of
all rows.
"""

MOST_TRIALS, FEW_TRIALS = 40, 8
"""Largest number of trials, and that of the law, whose sum of squares hardly falls beyond."""

INCREMENTS, MOST_SEARCHED = 150, 80
"""Smallest number of increments along a test; rows of a test, and increments, on which the starts search."""

PENALTY = 3.0
"""Residual, in multiples of the range, added to a row without equilibrium."""

FARTHEST = 0.12
"""Largest start of a slip over its range, before or after that of the rows."""

CANDIDATES = 13
"""Starts that are tried at once, at a sixth of the range to either side from each other."""

ROUNDS = 3
"""Rounds of candidates, each within one distance of the best before: their last distance is FARTHEST/216."""
