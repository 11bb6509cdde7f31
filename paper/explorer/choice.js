// What is chosen: a spring, an initial displacement, a step size over the period, an allowed error, two schemes and a
// colour. The address of the page holds it all.
const COLOURS = {
  error: "larger error of energy and period",
  energy: "largest energy error",
  period: "error of the period",
  outcome: "how the run ended",
}
const indexOf = (list, name) => list.findIndex((one) => one.name === name)
const within = (values, x) => Math.min(Math.max(x, values[0]), values.at(-1))
const springOf = ({problem}) => SPRINGS[meta.problems[problem].name]
const periodAt = (choice) => periodOf(springOf(choice), choice.u0)
const amplitudesOf = ({problem}) => meta.amplitudes.map((amplitude) => amplitude * meta.problems[problem].unit)

// The cell nearest to the chosen run, and whether that is its run.
function cellOf(choice) {
  const amplitudes = amplitudesOf(choice)
  const i = nearest(amplitudes, choice.u0), j = nearest(meta.steps, choice.step)
  const apart = Math.max(Math.abs(amplitudes[i] / choice.u0 - 1), Math.abs(meta.steps[j] / choice.step - 1))
  return {i, j, u0: amplitudes[i], step: meta.steps[j], exact: apart < 1e-4}
}

// The value of an axis of the maps that lies a number of places up or down.
function moved(values, value, by) {
  const next = by > 0 ? values.findIndex((one) => one > 1.0001 * value) : values.findLastIndex((one) => one < 0.9999 * value)
  return next < 0 ? value : values[within([0, values.length - 1], next + by - Math.sign(by))]
}

const first = () => ({
  ...meta.first,
  problem: indexOf(meta.problems, meta.first.problem),
  schemes: meta.first.schemes.map((name) => indexOf(meta.schemes, name)),
})

function addressOf({problem, u0, step, error, schemes, colour}) {
  const short = (x) => +x.toPrecision(6)
  return `#problem=${meta.problems[problem].name}&u0=${short(u0)}&steps=${short(1 / step)}&error=${error}` +
    `&schemes=${schemes.map((s) => meta.schemes[s].name).join(",")}&colour=${colour}`
}

// The choice that an address holds; what it lacks or gets wrong is as at first.
function choiceOf(address) {
  const given = new URLSearchParams(address.replace(/^#/, "")), choice = first()
  const problem = indexOf(meta.problems, given.get("problem"))
  if (problem >= 0) Object.assign(choice, {problem, u0: meta.problems[problem].unit})
  const schemes = (given.get("schemes") ?? "").split(",").map((name) => indexOf(meta.schemes, name))
  choice.schemes = choice.schemes.map((s, side) => (schemes[side] >= 0 ? schemes[side] : s))
  if (Object.hasOwn(COLOURS, given.get("colour"))) choice.colour = given.get("colour")
  if (meta.errors.includes(Number(given.get("error")))) choice.error = Number(given.get("error"))
  if (given.get("u0") > 0) choice.u0 = within(amplitudesOf(choice), Number(given.get("u0")))
  if (given.get("steps") > 0) choice.step = within(meta.steps, 1 / given.get("steps"))
  return choice
}

// The largest safe step over the period, for the allowed error at an amplitude of the maps; zero without one.
const safeStep = ({problem, error}, s, i) => part("safe", meta.errors.indexOf(error), problem, s, i)[0]
