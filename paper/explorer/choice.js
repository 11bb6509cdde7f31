// What is chosen: an oscillator, two schemes, a colour, and a run, which is a cell of the map or a run of the paper.
// The address of the page holds it all.
const COLOURS = {outcome: "how the run ended", error: "largest energy error", exponent: "Lyapunov exponent × T"}
const indexOf = (list, name) => list.findIndex((one) => one.name === name)

function caseRun(k) {
  const one = meta.cases[k], p = indexOf(meta.problems, one.problem)
  const step = one.dt / one.period
  return {case: k, i: nearest(Array.from(part("u0", p)), one.u0), j: nearest(meta.parts, step)}
}

function cellRun(i, j) {
  const clamp = (index, {length}) => Math.min(Math.max(index, 0), length - 1)
  return {i: clamp(i, meta.amplitudes), j: clamp(j, meta.parts)}
}

function first() {
  const run = caseRun(indexOf(meta.cases, meta.first.run))
  const [a, b] = meta.first.schemes.map((name) => indexOf(meta.schemes, name))
  return {problem: indexOf(meta.problems, meta.cases[run.case].problem), schemes: [a, b], colour: "outcome", run}
}

function addressOf(choice) {
  const run = choice.run.case === undefined
    ? `${meta.amplitudes[choice.run.i].toPrecision(4)},${meta.parts[choice.run.j].toPrecision(4)}`
    : meta.cases[choice.run.case].name
  const schemes = choice.schemes.map((s) => meta.schemes[s].name).join(",")
  return `#problem=${meta.problems[choice.problem].name}&schemes=${schemes}&colour=${choice.colour}&run=${run}`
}

// The choice that an address holds; what it lacks or gets wrong is as at first.
function choiceOf(address) {
  const given = new URLSearchParams(address.replace(/^#/, "")), choice = first()
  const problem = indexOf(meta.problems, given.get("problem"))
  if (problem >= 0) choice.problem = problem
  const schemes = (given.get("schemes") ?? "").split(",").map((name) => indexOf(meta.schemes, name))
  choice.schemes = choice.schemes.map((s, side) => (schemes[side] >= 0 ? schemes[side] : s))
  if (Object.hasOwn(COLOURS, given.get("colour"))) choice.colour = given.get("colour")
  const k = indexOf(meta.cases, given.get("run"))
  const [amplitude, step] = (given.get("run") ?? "").split(",").map(Number)
  if (k >= 0) choice.run = caseRun(k)
  else if (amplitude > 0 && step > 0) choice.run = {i: nearest(meta.amplitudes, amplitude), j: nearest(meta.parts, step)}
  return ofProblem(choice)
}

// A run of the paper belongs to one oscillator; on another, the choice falls on one of its own, or on the same cell.
function ofProblem(choice) {
  const {name} = meta.problems[choice.problem]
  if (choice.run.case === undefined || meta.cases[choice.run.case].problem === name) return choice
  const own = meta.cases.findIndex((one) => one.problem === name)
  return {...choice, run: own >= 0 ? caseRun(own) : cellRun(choice.run.i, choice.run.j)}
}

const sameRun = (a, b) => a.case === b.case && a.i === b.i && a.j === b.j
