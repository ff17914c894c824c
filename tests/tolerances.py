"""Every tolerance of the tests: one name, one home, one reason."""

# --- Hertz, Kalker and creep kernels ---
ROUNDING = 1e-12  # a few operations in double precision
HERTZ = 1e-13  # axis ratio solved to 1e-13; measured against the twin: 2e-15
HERTZ_QUADRATURE = 1e-12  # of the approach: the sum over chords converges exponentially; measured 5e-16
HERTZ_EXAMPLES = 6e-8  # half a unit of the table's eighth digit
HERTZ_MN_EXACT = 6e-7  # the table has 6 decimals
HERTZ_MN_CLASSICAL = 2.2e-3  # slide-rule values with 3 decimals; largest error 2.1e-3 (n at 70 degrees)
KALKER_NODE = 1e-12  # the same table, rounding only
KALKER_ASYMPTOTE = 0.07  # leading terms only, at g = 0.1; measured 6.4 % (C23, nu = 1/2)
KALKER_LIMIT = 1e-6  # at g <= 1e-6 the factor of at most 7 % that meets the table has faded to g / 0.1 of it
KALKER_C33_LONG = 0.035  # continued straight where the table bends as g squared; measured 3.0 %
BOUNDARY_ELEMENTS = 0.03  # 40 x 20 constant elements are too stiff by 1 to 2.5 %
BOUNDARY_ELEMENTS_SLENDER = 0.055  # the same, and what lies between asymptote and table; measured 4.6 % (C33)
DIFFERENCE_QUOTIENT = 1e-6  # central differences with steps of 1e-5 to 1e-6 of the variable
CONTACT_SLOPE = 0.03  # CONTACT on 61 x 61 elements, extrapolated by a parabola; measured 1.5 %
CONTACT_ROUNDING = 1e-6  # the file's six decimals
# Distance to CONTACT: mean and largest of the force over mu N, mean of the moment over mu N sqrt(a b); bounds are the
# measured values and a tenth. HARD cuts what Shen's cubic rounds: 0.30 at the corner. Without spin SMOOTH errs
# in direction, which the linear law keeps at full slip where C11 differs from C22. One factor for force and moment
# leaves a spin moment at full slip, where the true one vanishes. Heavy spin is outside the range of both laws.
CREEP_AGAINST_CONTACT = {
    ("HARD", "no spin"): (0.059, 0.29, 0.23),
    ("HARD", "light spin"): (0.072, 0.41, 0.24),
    ("HARD", "medium spin"): (0.10, 0.51, 0.28),
    ("HARD", "heavy spin"): (0.20, 0.77, 0.40),
    ("SMOOTH", "no spin"): (0.023, 0.103, 0.21),
    ("SMOOTH", "light spin"): (0.041, 0.12, 0.23),
    ("SMOOTH", "medium spin"): (0.066, 0.25, 0.25),
    ("SMOOTH", "heavy spin"): (0.142, 0.49, 0.34),
}
CREEP_SIZE_SMOOTH = 0.04  # Shen's cubic against the full solution; measured 0.036 at a : b = 1 : 2

# FaStrip, point by point and from its table, against CONTACT: the worse of both and a tenth.
STRIPS_AGAINST_CONTACT = {
    "no spin": (0.0043, 0.021, 0.0058),
    "light spin": (0.0063, 0.045, 0.0069),
    "medium spin": (0.0090, 0.077, 0.0089),
    "heavy spin": (0.0166, 0.074, 0.0134),
}
STRIPS_MEAN, STRIPS_LARGEST = 0.024, 0.12  # of the limit, 20 states of an ellipse; measured 0.022 at a : b of 5
STRIPS_OPPOSED = 0.031  # of the limit, full slip: the direction between tabulated ellipses; 0.028 at a : b of 18
FULL_SOLUTION = 0.05  # of the limit: 26 x 20 elements against 61 x 61; measured 0.043, 0.010 in the mean

CREEP_TWIN = 1e-10  # sums over 500 elements, differences of nearly equal terms of Polach's K_M
CREEP_TABLE_MEAN, CREEP_TABLE_MAX = 0.015, 0.06  # of the limit, spin beyond that of a flange; measured 0.010, 0.045
CREEP_BOUND = 5e-3  # of the limit: FASTSIM sums a pressure over 10 strips; measured 1.5e-3
CREEP_TANGENT = 1e-3  # of the limit: differences over 1e-6 of a creepage, and elements that begin to slip within them
CREEP_LINEAR = 8e-3  # of the limit: ten strips of FASTSIM; measured 6.6e-3
CREEP_MOMENT_LEFT = 0.02  # of limit times semi-axis, far beyond full sliding, where it vanishes as 1 / slip
CREEP_SCALED = 1e-9  # sums over 100 elements and interpolation of places rounded at 1e-16
CREEP_POWER = 1e-9  # of friction limit times creepage: no power is gained

# --- Profiles (lengths in m) ---
PROFILE_GRID = 1e-12  # a solved crossing: rounding of coordinates below 0.2 m
PROFILE_CURVE = 1e-10  # cubic pieces 0.25 mm long between points rounded to 1e-12 m; measured 1.4e-11
PROFILE_SLOPE = 1e-8  # rad: points rounded to 1e-12 m, 0.25 mm apart, and angles to 1e-12
PROFILE_RADIUS = 5e-5  # of a radius: the same rounding in second differences, worst on R300; measured 2.5e-5
CHORD = 3e-6  # a chord of 1 micrometre is (1 um / radius)^2 / 24 shorter than its arc: 2.7e-6 on R 0.1 mm
ROUNDED_CORNER = 5e-6  # tangents at a corner of 72 degrees bulge a piece 0.1 mm long by 2.4 micrometres
TANGENT_AT_A_JOIN = 3e-3  # rad: points 0.1 mm apart see half of a jump of curvature of 1/13 mm; measured 2.7e-3
FLANGE_DIMENSION = 1e-9  # sections are defined to 1e-12 m; the flank misses 32.5 mm by 3e-11
FLANGE_QR = 5e-6  # the published value has two decimals of a millimetre
GAUGE_POINT = 5e-8  # published to 1e-7 m
INDEPENDENT_PROFILE = 0.03e-3  # demanded of the agreement with digitised profiles
MANCHESTER_WHEEL = 1.3e-7  # section C is moved by up to 0.12 micrometres to close the steps at its ends
BROKEN_EDGE = 7e-6  # what radius 0.1 mm takes off the edge between tread and chamfer
MANCHESTER_RAIL = 1e-7  # measured 6.2e-8 once R80 is as wide as a head of 72 mm asks
EN15302_RAIL_TOP = 1.5e-6  # digitised from smoothed points; measured 1.0e-6
SECTION_STEP = 1.3e-7  # largest step of the published S1002 sections, 0.12 micrometres at s = -35 mm

# --- Vehicle, track and scenario descriptions ---
PRINTED_LOAD = 0.501  # [N] half a unit of the last digit of loads printed in kN with three decimals
STATICS = 1e-6  # [N, N m] rounding in least squares among loads of 1e5 N
PLACE = 1e-12  # [m] sums of a few coordinates of at most 10 m
TRACK_PLACE = 1e-9  # [m] 1e-12 per piece and rounding of some hundred metres, summed over up to 200 pieces
TRACK_HEADING = 1e-12  # [rad, 1/m, m] rounding in the shifted polynomials
TRACK_JOIN = 1e-10  # [m, rad] two pieces evaluated at the same place some hundred metres from the origin
TRACK_TANGENT = 1e-8  # [rad] chord of 0.2 mm: rounding of a position of 300 m over it, and its curvature's change

# --- Mechanics of the compiled core ---
TRACK_AXES = 1e-11  # [-] rounding of headings of some radian, summed over up to 200 pieces
TRACK_TURNING = 1e-11  # [1/m] central differences over 2 mm: rounding of axes, 1e-16 over 1e-3; measured 1.4e-12
TRACK_MOTION = 1e-9  # [-] likewise of places of 280 m, 6e-14 over 1e-3, and h^2/6 of second derivatives of 1e-5
RATE = 1e-7  # [m/s, rad/s] central differences over 0.2 ms of places of 300 m: rounding 3e-10; third derivatives 2e-8
RUN_PLACE, RUN_FORCE = 2e-6, 10.0  # [m], [N] windows of 10 m that repeat to this; a steady motion has no error of steps
NO_ALTERNATION = 1.0  # [N] rounding over contact stiffness is 1e-6 N; what a run still swings by is slow
STANDING_DRIFT = 2e-6  # [m/s] a force that creeps slides by 2.6e-5 here; demanded 1e-4; measured 1e-6, last swings
STANDING_PULL = 5e-3  # of m g sin: in R 300 m bodies point up to 36 mrad apart; swings of 0.1 kN at 9 Hz die slowly
STANDING_SWING, STANDING_ALTERNATION = 200.0, 10.0  # [N] of 60 kN a wheel; the same swings, and 5 N measured
COURSE_SPEED = 1e-3  # [m/s] six seconds after a ramp the hold's integral has forgotten it
SLIDING_BACK = 5e-3  # of g (sin - mu cos), a fourth of g sin: what swings on the springs
LOCKED = 1e-3  # [rad/s] of 0.8 when rolling; bogies swing on their springs
SMALL_CYCLE_HZ = 3.0  # of a limit cycle against the root about its centre; the spectrum's lines lie 1 Hz apart
SLOW_CURVE_KN, SLOW_CURVE_MM = 0.1, 0.02  # demanded; a small table, and 30 m of curve
GROUND_BALANCE = 1e-8  # over the weight, arms in m: accelerations of 1e-9 m/s^2 left by Newton's method; measured 1e-10
POWER_BALANCE = 1e-8  # of the traction's: the same times the mass; measured 1e-10
BENT_RAIL_POWER = 1e-3  # N keeps to the plane of the axle where the rail bends ahead: N V a_x / R, a_x to 10 mm
TWIN = 1e-9  # demanded of the NumPy twin; measured 3e-12 (rounding in stretches of stiff springs)
ENERGY_SLOPE = 1e-9  # relative: central differences over 2e-5, rounding and third derivatives 1e-10; measured 9e-11
RELAXATION = 1.2e-3  # of exp(-2): implicit midpoint at h k / c = 0.1 errs by 2 (0.1)^2 / 12 of it
IMPLICIT = 1e-5  # of the largest tension on unit masses: turns end where they change tensions by 1e-6
DRAWBAR = 5e-3  # creep under traction: the wheel turns by as much more than it rolls
STIFF_DAMPER_BALANCE = 2e-4  # sum Q at the end of a curve against Newton's: what is left of the entry
STIFF_BALANCE = 1e-6  # wheel loads against the weight: accelerations of 1e-6 m/s^2 are left
CREEP_POWER_BALANCE = 1e-3  # wheelsets rolling a steady curve: the speed of the car body is that along its own path
AXLE_BOX_ENERGY = 2e-2  # of the energy that swings: squares of h omega, 0.25 on the bearing
# Free bodies, relative, over 240 m at 40 m/s in steps of 0.25 ms; the kinks of a linear cant ramp cost first order
FREE_MOMENTUM = 3e-6  # measured 1.0e-6
FREE_ANGULAR = 2e-4  # about a point 240 m away; measured 6e-5
FREE_ENERGY = 2e-11  # measured 4e-12
# The same through vertical curves: 40^2 / 800 m/s^2 set in at once, within half a step; measured 3.0e-6, 9e-4, 2.5e-10
FREE_HILLS = (6e-6, 2e-3, 5e-10)
FREE_SMOOTH = 2e-7  # without kinks, angular momentum the worst; measured 8e-8
ORDER_TWO = 0.1  # of the ratio 4 of the errors at steps h and h / 2: the next order of the error
PARABOLA = 1e-7  # [m, m/s] squares of a step of 0.25 ms in axes that turn at 0.2 rad/s; measured 2e-8
PRECESSION = 3e-6  # [-] of a unit axle: squares of a step of 0.1 ms at 8 rad/s over 2 s; measured 1e-6
SPRING_ENERGY = 1e-4  # of the energy that swings: squares of h omega, 0.1 in the stiffest mode; measured 6e-5
BOUNCE_ENERGY = 5e-7  # likewise, contact and suspension in steps of 0.1 ms; measured 1.9e-7
ENERGY_ORDER = 0.02  # of the ratio 4: the next order of the error; measured 0.003
FLIGHT = 1e-6  # [J] rounding of 4e5 J in a flight: measured 2e-10
REBOUND = 1e-5  # of the height: steps of 0.01 ms in an impact of some ms
RESTITUTION = 2e-3  # the tread is 1 : 40 steep, and the branch bends as the wheel sinks in

# --- Dry friction and leaf springs ---
SWING = 2e-6  # [m] squares of h omega = 0.05 in the series spring over a swing of 0.25 m
STUCK = 1e-9  # [m] 5 % of damping has faded 2 s after it stopped
STUCK_FORCE = 1e-3  # [N] rounding of places of 5 m, 1e-15, times 1e7 N/m
SLIDING = 1e-3  # of the speed after 2 s: the series spring swings once before it slides
LOOP = 1e-4  # of the area: 4000 samples, and corners that fall between them
TRACTRIX = 5e-3  # of F / ks: a sample is 0.8 % of it, half of which the end lags behind
OPTIMISED = 1e-5  # of the limit: a simplex stops at 1e-10 of F / ks, where the cost is flat to its square root
NEARLY_DRY = 2e-5  # [m] of 0.1 m: the table's force is not full below 0.01 mm/s
LEAF_LOOP = 2e-3  # of the area: trapezoids over 400 samples; exact in between
LEAF_FADED = 1e-3  # of the largest force: exp(-2 A / b) = 5 % a turn, after four loops
LEAF_TWIN = 2e-3  # of the force: a chord across a knot of the envelopes; measured 1.2e-3, without knots 1e-9
STUCK_MODE = 5e-6  # relative: differences over 1e-7 m of a leaf spring that bends over 2 mm; measured 1.4e-6
DRY_ENERGY = 1e-3  # of all that is lost: squares of a step of 0.05 ms, and places half a step apart
Y25_BALANCE = 5e-4  # demanded; measured 2e-6 at every interval

# --- Equivalent conicity ---
CONE = 1e-9  # [-, m] delta-r of a cone is exact; what remains is rounding and the search along the locus
CONE_ROLLED = 2e-3  # relative: the closed form leaves out squares of the slope, 0.1 at most
CIRCLE_PLACE = 2e-6  # [m] cubic graph with 0.05 mm steps through arcs
CIRCLE_RADIUS = 2e-8  # [m] the place's error times a slope of at most 0.1
CIRCLE_ANGLE = 2e-5  # [rad] the place's error over a radius of 0.1 m
MIRROR_RADIUS = 1e-9  # [m] the search stops at 1e-9 m on the profile
MIRROR_CONICITY = 1e-6
MIRROR_CENTRE = 1e-9  # [m]
DELTA_R_CHORD = 0.3e-6  # [m] delta-r runs straight within 0.1 micrometres between its positions
ROLL = 1e-6  # [rad] the same chord over 1.5 m and a nearly straight roll
WAVELENGTH = 3e-5  # a Runge-Kutta solver that meets corners and jumps of delta-r unprepared, steps of 20 mm
TURNING_POINT = 1e-7  # [m] the same
EN15302_CONICITY = 0.002  # demanded away from jumps; the tables have three decimals
EN15302_DELTA_R = 0.8e-6  # [m] half a unit of the last digit, and sections that meet to 0.8 micrometres; measured 0.7
EN15302_EDITIONS = 2e-6  # [m] noise of the digitised points
EN15302_ROLL = 1.5e-6  # [m] known to 1 micrometre; measured 0.9

# --- Import and curation of profiles ---
IMPORTED_ROUNDING = 1e-9  # [m] canonical files have 9 decimals of mm; inches and metres in samples have 9 digits
IMPORTED_WHEEL = 2.5e-7  # [m] Manchester wheel on the bundled one: 0.12 um of section C, and its own last digit
SAME_RAIL_CONICITY = 3e-3  # relative; a file of the same rail, 0.03 um apart, its points round jumps of curvature
TAPE_THICKNESS = 0.1e-3  # [m] below a tape circle 0.11 mm lower the flank stands 0.04 mm further out at 70 degrees
TAPE_RADIUS = 5e-8  # [m] one curve on two grids of 0.05 mm that are 3.8 mm apart
INSTRUMENT_MM = 0.05  # Sd, Sh, qR of the instrument's own smoothing against unsmoothed points; measured 0.04
LIP = 2e-5  # [m] tangents at the corner where a gauge face is continued bulge the last piece by some micrometres
STITCHED = 0.03e-3  # [m] the mean of two points 0.1 mm apart on the same curve, off by its sagitta on the tightest arc
CUTOFF_GAIN = 3e-3  # uneven spacing and the ends; measured 1.2e-3 (2.8e-3 at half the cut-off, 6 %)
SHRINK = 2e-9  # [m] of an arc: (C / 2 pi R)^4 R is 183 nm for C = 5 mm, R = 13 mm; the next order is 1e-5 of it
ROTATED_SMOOTHING = 1e-9  # [m] smoothing has no axes: rounding, and a band solver at weights that range over 1e3

# --- Comparison with the published curve ---
IDENTIFIED = 1e-5  # of friction: the search stops at 1e-6, twice the jackknife error at a few times that
PRINTED_TENTH = 0.05  # [mm, kN] half a unit of the last digit
R150_TRAILING_Q = 0.7  # [kN] beyond either code: half of the transfer of 1.6 kN, in one bogie's wheelsets
R150_TRANSFER = 0.4  # [kN] the codes differ by 0.3; eight values with one decimal
R150_BALANCE = 0.1  # [kN] lean of the bodies, which the closed form leaves out; measured 0.046
COOPERRIDER_CONICITY = 0.05  # roll moves the contact of railcli's wheels, which the table leaves out; 0.043
COOPERRIDER_PLACE = 0.6e-3  # [m] the same, and the table's angles against those of its rail; measured 0.5
COOPERRIDER_ANGLE = 6e-3  # [rad] of the table against UIC60 at the same place, beyond y = 4 mm; measured 5.5e-3
COOPERRIDER_HZ = 0.05  # read off some five peaks, stored every 10 ms
GYROSCOPIC = 0.01  # of the spin: what contact adds to the slope of yaw acceleration over roll rate; measured 0.0013

# `railcli run scenario`
BALANCE_KN = 0.2  # sums of rail forces against mass times acceleration: what is left of the run-in at the end of a run

# --- Contact geometry and its table ---
SIMPLEX_PLACE = 1e-6  # [m] demanded; both end in the same Newton iteration, measured 5e-11
SIMPLEX_GAP = 1e-9  # [m] demanded; measured 2e-16
SCAN_BARRIER = 5e-6  # [m] what rises less between two minima half a millimetre apart, a scan of 0.25 mm may not see
GRID_BARRIER = 2e-6  # [m] shallower minima drown in the coarse grid
GRID_PLACE = 2e-5  # [m] D is flat: within 1e-9 m of the minimum over this length
GRID_DIP = 2e-6  # [m] steps of 20 micrometres and 0.25 mrad on curvatures of 1/13 mm and of 1/0.46 m
GRID_DIP_PLACE = 0.15e-3  # [m] D within GRID_DIP of the lowest
GRID_GAP = 1e-8  # [m] chords of 5 micrometres and a last grid of 0.3 by 6 micrometres on radii of 13 mm
CIRCLE_GAP = 1e-9  # [m] cubic graph with 0.05 mm steps through arcs
STATION = 1e-6  # [m] profile graphs have a grid of 0.05 mm
AT_A_NODE = 1e-13  # [m, -] rounding of a place in the grid times what changes over a cell; measured 3e-15
AT_A_NODE_RELATIVE = 1e-9  # the same of large values; measured 4e-11
SMOOTH_GAP = 1e-10  # [m] quadratic interpolation of a surface whose third derivatives vanish; measured 1.4e-12
SMOOTH_PLACE = 1e-9  # [m, -] the same of place, slope and radius over cells of 1 mm x 1 mrad; measured 1.4e-10
PARABOLA_SLOPE = 1e-12  # [-] rounding of differences of places of some millimetres over steps of 0.1 mrad^2 and more
GAP_GRAIN = 1e-9  # [m] where the depth of first touch hardly moves
GAP_SLOPE = 2e-5  # [-, m/rad, m/rad^2] differences over 2e-6: rounding 1e-10; jumps of curvature within the step
BALANCE_BY_HAND = 1.0  # [N] the last digit of a sum done by hand
SETTLED_RUN_MM = 2e-3  # at 45 m/s a trailing wheelset still swings by 0.006 mm in the last 100 m; means measured 3e-4
HELD_IN_PLACE = 1e-3  # [N] Newton stops at 1e-7 m/s^2 of 1.8 t; measured 2e-7
FORCE_GRAIN = 2.0  # [N] of 1e5 N: rounding where the force hardly moves
MIRROR = 1e-12  # relative: the same operations with other signs, in another order
CREEP_SLOPE = 2e-3  # of the largest entry: the damping leaves out the change of |v|, a creepage's worth of it
SIX_DIGITS = 1e-5  # relative: half a unit of the sixth digit
WEIGHT = 1.0  # [N] static equilibrium to 1e-7 m/s^2, and wheels that lean by a contact angle

STEP_TWIN = 1e-9  # ten steps; the twin's creep damping comes from differences, 1e-7 of it; measured 2e-10
LAST_DIGIT = 4e-16  # two units of the last digit of a double
SOLVED = 1e-11  # elimination without pivots, condition numbers up to 1e3

# --- Equilibria and runs of the wagon ---
STATIC_LOAD = 5.0  # [N] demanded to three decimals in kN; the end of the axle-box springs' rounding
STATIC_BALANCE = 0.1  # [N] an acceleration of 1e-7 m/s^2 left over on 44 t
UPRIGHT = 1e-9  # [m, rad] the same over the softest stiffness
CURVE_BALANCE = 20.0  # [N] bodies beside or above the centre line run on another radius: 1e-4 of 74 kN
EVEN_LOADS = 0.025  # leading outer wheels bear on the flange root, 25 to 38 mm nearer to the middle than inner ones
MIRRORED_PLACE = 1e-8  # [m, rad] Newton's method stops at 1e-7 m/s^2
MIRRORED_FORCE = 1.0  # [N] the same
STEADY_PLACE = 1e-6  # [m, rad] demanded
STEADY_FORCE = 10.0  # [N] the same times the stiffness of a flange contact of 1e8 N/m, not all of it in one direction
HALVED_STEP = 5e-6  # [m] demanded
TURNED = 1e-9  # [m, rad] rounding of places of 1000 m, 1e-13, times contact stiffness over mass, in 4000 steps
SECOND_ORDER = 0.1  # the table's slopes bend at its nodes, which each step size meets elsewhere; measured 2.03
OTHER_CODE = 1e-9  # demanded; contraction of a * b + c rounds once less
KLINGEL = 6e-3  # his formula leaves out r tan(angle) / b, half of it in a wavelength: 0.8 % at 0.025; measured 0.5 %
SPIN = 1e-9  # relative, over 2000 steps: rounding of forces of 1e5 N
CONE_PLACE = 1e-7  # [m] cells of 1 mm interpolated over a round rail, over a slope of 0.05; Newton stops at 1e-7 m/s^2
CONE_ROLL = 1e-8  # [rad] loads that differ by 1e-3 press in by 5e-9 m more or less, over 1.5 m
PRESSED_IN = 3e-5  # [m] what 10 kN press a wheel of 0.46 m into a head of 0.3 m: 1.9e-5
GRID_ROUNDING = 1e-12  # [m] a whole number of steps
STRAIGHT_ON = 0.02  # gravity on a round rail pushes back a little
FREE_STRAIGHT_ON = 0.06  # weight on round rails and spin moments, of 1 N m, turn and move what nothing else holds
FREE_SPIN = 3e-6  # relative; the wheels still yaw a little on their bearings
FREE_LOAD = 1e-3  # relative; the Newton search leaves wheel loads apart by as much
FREE_SHARE = 0.02  # of the friction limit; what turns the wheels along as the wagon still sways
FREE_PATH = 1e-4  # relative; the same, and the wheels' own yaw on their bearings
FREE_COUPLE = 1e-2  # of the longitudinal force of a wheelset in the same place

# --- Non-Hertzian patches ---
ELLIPTIC = 1e-12  # arithmetic-geometric mean, quadratic convergence
STRIP = 1e-8  # of adaptive quadrature with its integrand's roots at both ends

# --- Patches of a loaded wheelset ---
LONE_PATCH = 1e-9  # relative: exact arcs, depth solved to 1e-13 m of 1e-4 m; measured 4e-11
POLYGON = 5e-4  # relative: 120 chords enclose 1 - (2 pi / 120)^2 / 6 of an ellipse
LOAD_BORNE = 1e-8  # relative: depth solved to 1e-13 m of 1e-4 m; measured 1e-9
UNLOADED_PLACE = 1e-7  # [m, rad] 1e-3 N presses a wheel in by 1e-9 m; measured 2e-8
TABLE_FORCE = 0.01  # of the load: distances of a table err by 1 micrometre of 80 (p99) at worst; measured 0.005
TABLE_PLACE = 3e-5  # [m] places of a table are interpolated linearly; measured 7e-6

# --- Contact benchmark ---
BENCH_LOAD = 1e-9  # the height is found to 1e-14 m, times a stiffness of 1e9 N/m at most
BENCH_MOMENT = 1e-5  # [N m] the same times the radius, and the spin found to 1e-13 rad/s, times 1e6 N m s/rad
BENCH_ROLL = 1e-11  # [rad] found to 1e-12
BENCH_MIRROR = 1e-6  # relative, and [m]: a roll off by 1e-12 moves heights by 1e-12 m of some 1e-5
BENCH_PLACE = 1e-6  # [m, -] interpolation over cells of 1 mm of a round rail
BENCH_SPIN_PULL = 1e-3  # of the friction limit: rotation by spin over a wheel of 1:20 leaves no pull but its own share
PRINTED_FORCES = 6e-3  # angles printed to 0.01 degrees and four digits of forces, on a flange of 61 degrees
BENCH_HEIGHT = 5e-6  # [m] what roll adds to where a yawed wheel touches, at 11 mrad; measured 3.3e-6

# --- Linear analysis ---
EIGENVALUE = 1e-9  # relative: forces are linear, rounded at 1e-16 of 1 m over steps of 1e-7 m; measured 3e-11
BAND_RMS = 2e-3  # of a sine: 1e-3 is the tenth that the band-pass lets through of a harmonic; its ends
CYCLE_RMS = 0.03  # largest of windows of 7.4 periods: 1 / (2 omega T) = 1.1 %; spectra of 4 and 5 s move the band
BLOCKED = 1e-8  # relative: the same, and bodies of 32 t on rounded heights; measured 1.2e-9
BLOCKED_PLANE = 5e-6  # relative: rounding under springs of 1e9 N/m; a nearly critically damped pitch 2.4e-6
HALF_A_DIGIT = 0.51  # of a unit of the last digit printed
PRINTED_HZ = 6e-5  # [Hz] half a unit of the last digit
TEXTBOOK = 1e-3  # relative: the heavy frame swings along, 1e-4 of the frequency squared, and rolls; measured 5e-4
TEXTBOOK_CREEP = 0.01  # relative: two roots 10 % apart take up each other's errors; measured 5e-3
WICKENS = 4e-3  # relative: his formulas are of first order in the angle of 0.04, amplitudes finite; measured 2e-3
SAME_CONE = 2e-4  # relative: table cells of 1 mm and 1 mrad; roll that moves a contact is left out; measured 2.4e-5
BY_HAND = 1e-3  # relative: wheels stand on springs of 1e9 N/m each under 1e7 N/m; measured 4.5e-4
PITCH_BY_HAND = 0.01  # relative: traction rods pull 1.2 m below the centre; measured 5e-3
OTHER_PLANE = 1e-8  # of the largest displacement: rounding of differences over gaps between eigenvalues; measured 6e-11
MIRRORED_MATRIX = 1e-9  # of the largest entry: rounding of differences
STEP_FREE = 1e-6  # relative: (h/d)^2/24 of Hertz's law, h = 1e-7, d = 8e-5 m, and rounding; measured 3e-8
EIGENVECTOR = 1e-10  # relative to the sizes summed
BIORTHOGONAL = 1e-6  # equal eigenvalues have freely chosen vectors; rounding over their distance
FREE_SWING = 2e-3  # of the amplitude: 0.4 s of the integrator at 0.1 ms; Hertz's law over an eighth of its depth
BOUNCE_RUN = 1e-4  # of the frequency: other vertical modes ring in the first half period, which is left out
BOUNCE_DECAY = 0.01  # of the decay: peaks are read at intervals of 5 ms of 0.93 s
GROWTH = 0.02  # of a growth of 0.5 per second: peaks are read at 25 ms of 0.18 s; measured 7e-3
TABLE_OR_LINES = 0.01  # relative: curvature of the profiles over 0.5 mm; what roll does to a contact
SAME_CYCLE = 0.02  # of the amplitude: a ramp stops at 1 % of change from window to window
CYCLE_FREQUENCY = 0.05  # relative: one amplitude stands for four wheelsets of 1.7 to 2.9 mm; creep that saturates
DESCRIBING = 1e-6  # straight between 1/1000 of the amplitude; rounding of distances of 1e-3 m over 1 mm
BOTH_TOUCH = 1e-9  # [m] second order of a roll of 6e-6 rad and of its slope
LINE = 1e-4  # relative: second order in y = 0.1 mm and its roll
SINE = 1e-5  # relative: crossings by straight lines between 75 samples per period
MOVED_TOGETHER = 1e-9  # of the largest entry of the matrix: rounding of differences
LONG_WAVE = 5e-4  # at 1 mHz: wheelsets that roll follow a lateral wave of 30 km some metres late
RESPONSE = 0.01  # demanded for the vertical model by hand: traction rods and their pitch are not in it

# --- Gradients, vertical curves, twist ---
COASTING = 0.015  # of the work of the weight: bodies bounce and pitch at the end, springs hold more; measured 0.007
COASTING_ENERGY = 5e-8  # of the same: squares of a step of 0.1 ms; measured 1.5e-8
VERTICAL_CURVE = 0.01  # of m V^2/R: the bounce of its beginning is not all over; measured 0.006
TWIST_BY_HAND = 0.03  # of the largest change: contacts are not all 1.5 m apart, wheelsets lie aside; measured 0.022
TRACK_SINE = 7e-7  # of the change over a transition: cubics in place of a sine, (2 pi)^3 / 384 / 32^4 = 6.2e-7
ELEVEN_POINT_EIGHT = 2e-4  # 1500 / 9.81 / 3.6^2 is 11.798
CHORD_SLOPE = 0.02  # a chord over 1/30 of a transition: (1/30)^2 of the slope, or 1/60 at the corner of Helmert's
LIFTING = 0.005  # where the wagon swings on its way up; measured 0.0012

# --- Rails beside their ideal place ---
SHIFTED_PLACE = 1e-9  # [m, rad] rounding of places some millimetres away, times contact stiffness over mass
SHIFTED_FORCE = 1.0  # [N] the same times the stiffness of a contact
TURNED_CONTACT = 1e-8  # relative: rounding of places, 1e-16, over a depth of 1e-4 m, and of sines of angles
PARALLEL_CURVE = 4e-6  # [m] the rail runs straight under the wheel: (r z')^2 z'' / 2 = 2.6 micrometres is left out
BUMP_ENERGY = 1e-3  # of the energy climbed: squares of the step of 0.1 ms times 240 Hz
APPROACH = 2e-3  # of the largest rate: quadratic interpolation of D against slopes interpolated linearly
CROSS_LEVEL_ROLL = 0.03  # the axle stands beside the middle then, on other radii: 0.04 mm of 4 mm a side
GAUGE_CENTRE = 1e-3  # [m] S1002 hardly steers within its clearance: the wheelset stops somewhere about the new middle

WIDENED, WIDENED_FORCE = 1e-8, 1.0  # [m], [N] Newton's residual of 1e-8 m/s^2 on soft directions

# --- Irregularity ---
PRINTED_RMS = 0.6e-3  # [mm] half a unit of the third decimal
PRINTED_AAR = 0.6e-5  # [mm] half a unit of the fifth decimal
PARTIAL_FRACTIONS = 1e-9  # relative: differences of arcus tangents; quadrature to 1e-11
PARSEVAL = 1e-9  # rounding of a Fourier sum
WAVE_SLOPE = 0.03  # central differences of the shortest of waves at 16 samples: (2 pi / 16)^2 / 6
CHANCE = 0.2  # correlation of two series of 20 km with a few hundred effective waves
SHAPE_SLOPE = 2e-3  # per metre: central differences over 0.1 mm where curvature jumps by 10 1/m
SAMPLED_SLOPE = 1e-6  # central differences over 5 mm of waves of 4 m
MEASURED = 5e-8  # [m] a spline through sines sampled at 1/75 of their length; six decimals of mm
WRITTEN = 1e-10  # [m] seven decimals of mm

# --- Reports ---
WELCH_POWER = 1e-9  # a sine of whole periods in a segment: the Hann window's weights sum up exactly but for rounding
SHOWN_DIGITS = 5e-4  # tables of a report show four digits
DRAWN_CONTACT = 5e-6  # [m] the picture leaves out yaw: a flank of 60 degrees under 2 mrad, r yaw^2 tan^2 / 2 = 2.8e-6

# --- Assessment ---
FILTER_GAIN = 1e-6  # in the middle of a long sine, where the ends' transients have died away
FILTER_EXACT = 1e-10  # rounding of a constant through recursive sections
SLIDING_MEAN = 1e-5  # relative: cubic spline through 40 samples a wavelength, error (pi / 40)^4 / 6
PRINTED_THREE = 6e-4  # of a magnitude printed with three decimals
WEIGHTED = 1e-9  # the filter works on the spectrum: a whole number of periods leaves rounding only
WEIGHTED_START = 2e-4  # of the amplitude: the reflection at an end is no sine; what is left of it 10 s later
SPERLING_FACTOR = 1.2e-3  # 4.42 has three digits; it stands for (100 sqrt 2)^0.3 = 4.4172
BETWEEN_RANKS = 1e-3  # of a percentile of 100,000 quantiles: the outermost 0.15 % are 150 of them
FREQUENCY = 0.025  # [Hz] grid of the padded spectrum
FLOOR_SPLINE = 1e-6  # [m/s^2] derivative of a cubic spline at 100 samples a period, (2 pi / 100)^4 / 180 of 1 m/s^2
BLOCKWISE = 1e-6  # relative: what is left of a filter's start after 10 s; blocks must not be seen
SIGNAL = 5e-3  # of a figure: samples lie beside crests; a high-pass remembers 0.3 % of a reflected start after 3 s
OVERSHOOT = 0.05  # of a step through a low-pass of fourth order; measured 0.027
COARSE_SINE = 6e-3  # 8 Hz recorded at 100 Hz: samples lie up to 2 pi 8 / 200 from the crest, 25 phases in all
SECTION_ENDS = 8e-3  # of an rms: a section of 10.2 periods ends within one, 1 / (2 omega T) = 1 / 128
STEADY_END = 2e-3  # median of a section against the mean of the last 50 m, where the motion has settled to 1e-3
ONE_ROW = 5e-3  # of a mean over 350 rows: sections weigh by length, rows of the file do not
RECORD_END = 0.02  # of the amplitude: a high-pass of 0.4 Hz that started backwards 2 s ago with an error of a fifth

# --- Linear vertical model ---
CLOSED_RESPONSE = 1e-8  # relative: the same equations solved in another order; contact forces are small differences
VERTICAL_WAVE = 2e-3  # relative: squares of 0.02 Hz over the car body's 1 Hz
SAMPLED_RESPONSE = 0.01  # inputs run straight between samples: 3e-6 of the height, times the contact's stiffness
MIRRORED_RUN = 1e-9  # [m] rounding, grown over 4 s; measured 2e-14
FOLLOWED = 1.5e-3  # [m] a wheelset of low conicity stops within a part of its clearance
DETRENDED = 0.01  # of an RMS: the straight line through a period takes up to 6 / pi^2 / 20^2 of it, 20 longest waves

# --- Longest step ---
STEP_BISECTED = 0.011  # a limit is bisected to 1 %, from below
STEP_ROOT = 1e-6  # of the eigenvalue -1: a simple root of a cubic
STEP_FOUND = 1.06  # share of the limit at which 3 s decide: a disturbance beyond it grows by 0.7 % in each step
STEP_QUIET = 1e-4  # change of a wheel force within a step at the end of a quiet run, relative
STEP_FLANGE = 0.03  # tables with other steps meet the place of three patches with other depths
STEP_PRINTED = 0.02  # limits are printed with three digits, rounded down
STEP_MASS = 0.03  # the damping of the contacts, 2 s/m, does not scale with the root of the mass
OVER_INTERVALS = 1e-3  # of an assessment: the end of the run and of its last window are rounded to whole rows
PASSED_RIPPLE = 2e-3  # of the low-pass as its docstring states it
FOLDED = 1.2e-3
SUMMED = 1e-9  # a thousand squares of differences in double precision
SINGLE = 1e-6  # of the largest: a number in single precision
SINGLE_SUM = 1e-5  # of the largest: a sum of a hundred numbers in single precision
SPECTRUM_LINE = 0.02  # a line of 0.5 Hz, padded to an eighth
BEGINNING = 5e-6  # [m, rad] on straight track the force that holds the speed, 5 N, has to be found
BEGINNING_FORCE = 20.0  # [N] of 55 kN; likewise

# --- Rails that give way ---
RAIL_DEFLECTION = 1e-9  # balanced to 1e-6 N of some 1e4 N
RAILS_SPREAD = 2e-2  # rails that also part by some hundredths of a millimetre let the wheelset sink a little more
RECEPTANCE = 1e-6  # demanded of the track model; differences of 1e-7 m and 1e-5 m/s, measured 6e-10
RAIL_FORCE = 1e-6  # N: rounding of a stiffness of 1e8 N/m times places of 1e-3 m
RAIL_LAG = 1e-4  # the normal force of a step knows the creep forces of the step before; measured 1.6e-5
RAIL_ENERGY = 2e-3  # of the energy fallen: forces belong to the middle of a step, places to its end; measured 4e-4
RAIL_RESTS = 6e-6  # m: left of a fall of 0.5 mm after 0.8 s; measured 2.3e-6
RAIL_BEARS = 1e-2  # N: accelerations of up to 1e-7 m/s^2 may be left
RAIL_STAYS = 1e-9  # m: a steady motion is a fixed point of the step
RAIL_MIRROR = 1e-12  # m: rounding
RAIL_ALL_BUT_RIGID = 2e-6  # m: 54 kN on 1e11 N/m are half a micrometre
BEAM_ON_BED = 2e-4  # wave numbers cut off at 200 1/m leave out 2e-6; the slope is taken over 1e-3 of the range
P2 = 0.02  # the formula is of first order in the damping, and takes a rail that parts from level at once
STRIKE = 0.06  # of a peak: at 1 ms the force is seen once in each millisecond of a strike; measured 5.3 % (slab)

# --- Normal contact on elements ---
CONE_HERTZ = 1e-4  # places between nodes move the rolling radius by 1e-6 m, and the load by its depth
CHECKED_PLACE = 1e-6  # [m] as BENCH_PLACE
ELEMENT_FORCE = 1e-3  # of Hertz's, 40 by 60 elements over the ellipse; measured 2e-4
ELEMENT_PRESSURE = 2e-3  # uniform over an element: the mean about the middle, and half an element beside it
ELEMENT_AREA = 0.01  # strips end between elements; measured 0.4 %
ELEMENT_GAP = 1e-4  # of the greatest overlap: conjugate gradients stop when pressures move by 1e-7 of their sum
RECTANGLE = 1e-9  # of an integral that scipy's quadrature gives
FAR_PATCH = 3e-3  # a patch of 3 mm seen from 15 mm is a point but for (a / r)^2 / 5, of a pull of a tenth
CONFORMING = 0.06  # times the square of the half angle: arc for chord, and both widen; docs/contact-validation.md
TOUCH = 1e-9  # [m] minima of two searches, each 1e-6 m of its place, times slopes that vanish there
STORED_ROLL = 1e-9  # [rad] printed with six decimals of a milliradian
STORED_TOUCH = 2e-9  # [m] printed to the nanometre
COARSE_SINK = 1e-3  # from fewer elements to the stored ones
COARSE_PRESSURE = 0.01
COARSE_AREA = 0.03
COARSE_PLACE = 0.02e-3  # [m]

# The normal law of strips
STRIP_SLOPE = 2e-3  # differences of an energy known to 1e-7 over steps of 0.2 um, second order in a patch's edges
STORED_SLOPE = 1e-6  # of the force, arms of 1 m: differences of the energy over 0.01 um or 0.1 urad; measured 4e-7
STORED_SLOPE_BENT = 1.5e-4  # the same where rails bend under the wheel, which the table leaves out; measured 7e-5
CLOSED_PATH = 1e-3  # of the largest energy: the aim of the law, with the trapezoidal rule along the path
CONVEX = 1e-3  # of the largest energy: a force falls by no more as patches join
FINE_SWEEP = 200.0  # [N] over 50 nm: a wheel of 70 kN on a flank of 70 degrees gains 60 N by depth alone
JOINING = 0.05  # second difference of the force over 10 um: 80 um of overlap grow by a third
STORED_PLACE = 0.02e-3  # [m] between nodes
STRIP_WIDTH = 5e-3  # four strips over a half width leave 0.7 % of the force, eight 0.2 %
STRIP_EDGE = 0.03  # of area and greatest pressure: a patch ends with a strip, of which there are twenty
STRIP_PLACE = 0.05e-3  # [m] where loads of strips of 0.4 mm balance

# --- Certificate of forces ---
CONE_APPROACH = 1e-10  # Hertz's law itself; measured 1e-12
CONE_LOAD_CENTRE = 1e-6  # [m] places by the search along the locus
CONE_LOAD_ANGLE = 2e-5  # [rad] that place over the radius of the head
FORCE_OF_ENERGY = 3e-4  # differences over 5e-8 m of energies whose influences are in single precision; measured 1e-4
NODE_FORCE = 1e-8  # [%] rounding
NODE_PLACE = 1e-8  # [mm] rounding
CONE_TABLE_PERCENT = 1e-4  # of a table in which everything is smooth; measured 7e-6
CONE_TABLE_MM = 1e-6
CONE_STRIPS_PERCENT = 0.08  # 1.493 after the second order, and 0.047 of the strips of the levels, wider than the law's
INFLUENCE = 5e-5  # the polynomial is within 3.2e-5
INFLUENCE_SLOPE = 1e-3  # and what follows from its slope within 6.4e-4
HERTZ_STRIPS = 5e-3  # eight strips over a half width, of at most a quarter of their half length
ENERGY_START = 1e-5  # iterations end when they add 1e-8, which falls slowly in what the energy hardly feels

# --- Recorded tracks ---
THREE_DECIMALS = 0.501e-6  # [m] of mm
FOUR_DECIMALS = 1e-7  # [m] of mm, and a spline through them
CANT_BY_PLACE = 2e-6  # [m] a spline over the kinks of a cant ramp of 1.7 mm/m, sampled every 0.25 m
FITTED_STEP = 1e-4  # rounding to four steps, on the mean of 400
RESTORED = 2e-4  # [m] of waves of 8 mm in all; the record's ends are 20 chords away
FOUND_END = 12.0  # [m] half of the 20 m over which curvature is averaged

# Brakes and drives
UNBOOKED = 1e-3  # of the kinetic energy: the share that a ledger may leave out at a step of 1 ms
CREEPS_NOT = 1e-6  # [m] within 15 s: a wheelset that its brake holds on a gradient, once the car body swings no more

# --- Parameter studies ---
SUM_OF_A_GRID = 1e-14  # rounding of a place between two ends, against that of numpy.linspace
MOMENT_OF_A_SAMPLE = 2.0 / 4000  # share of 4000 evenly drawn values: one value on each side
ISHIGAMI = 0.06  # indices of 1024 base points: three times their 95 % interval of 0.02 at most for totals
ISHIGAMI_BY_BALANCE = 0.05  # of 4000 points: ten harmonics over-estimate by some 0.01, noise is as much
