"""Meaning of the words of the claims: groups of schemes, and one threshold for each kind of judgement."""

#: Groups of schemes that the paper judges together.
FAITHFUL = ["average_acceleration", "central_difference"]
DISSIPATIVE = ["newmark_dissipative", "wilson_theta", "houbolt"]
DAMPED = [*DISSIPATIVE, "hht_alpha_1996"]
UNCONDITIONAL = ["average_acceleration", *DAMPED]
EXPLICIT = ["central_difference", "rk4"]
IMPLICIT_NEWMARK = ["average_acceleration", "newmark_dissipative"]

#: Largest error, in percent, of an energy or a displacement that is "reasonable" or "fairly accurate". Also the largest
#: error of a balance of energies that counts as kept. A scheme with a larger error is "unsuitable". If its
#: error is always larger, it is "never" to be used.
REASONABLE = 10.0
#: Energy error in percent above which a result is "far" from the exact solution, in "grave" error, "meaningless", or
#: "strongly" damped.
FAR_OFF = 50.0
#: Energy error in percent above which a run is "unstable". A run of a spring that only loses energy stays below
#: 100, up to round-off.
UNSTABLE = 101.0
#: Excess over the initial energy, in percent, above which the energy in the second half of a run has grown.
GROWN = 100.0
#: Ratio of errors up to which a scheme is "almost as accurate" as another, and above which a run is "less accurate".
ALMOST = 1.1
#: Least ratio of errors for an accuracy that is improved "significantly".
SIGNIFICANTLY = 2.0
#: Least ratio of errors if one scheme is "far more accurate" than another, or if results "vary greatly".
GREATLY = 10.0
#: Rank correlation of the errors on two springs above which the schemes behave alike.
ALIKE = 0.8
#: Number of periods within which a motion that is damped "rapidly" loses ``FAR_OFF`` percent of its energy.
RAPIDLY = 10.0
#: Largest ratio of the times of two schemes if the first scheme costs "much less". Largest ratio if it costs "slightly
#: more".
MUCH_LESS, SLIGHTLY_MORE = 0.75, 1.5
#: Share of cases above which something happens in "most" of them or "often".
MOST = 0.5
#: Share of cases above which something is "not uncommon".
NOT_UNCOMMON = 0.05
#: Distance beyond which two runs with almost equal starts are different motions, and the scheme is "chaotic".
APART = 0.1
#: Lyapunov exponent per step above which a map is chaotic. After a thousand steps of a regular map the computed
#: exponent is below 0.01.
CHAOTIC = 0.05
#: Number of different durations among the stays in a well. With more durations, jumps are "irregular".
IRREGULAR = 5
#: Largest distance of the steps per oscillation from a whole number for a motion "in resonance" with the step.
RESONANT = 0.05
#: Largest range of a displacement "at rest".
AT_REST = 0.01
#: Smallest observed order of a scheme that "is of second order", and of one that "is of third order".
SECOND_ORDER, THIRD_ORDER = 1.5, 2.5
#: Largest relative size that counts as zero up to round-off.
ROUND_OFF = 1e-10
#: Error of a displacement, in percent, above which the error matters. Error of a balance of energies, in percent, below
#: which the error is unnoticed.
MATTERS, UNNOTICED = 0.1, 1e-6
#: Number of steps in a period by the rule of practice; the paper's rule, T/20, is the same.
RULE = 20
