// The data of the page. `meta` describes them, and the arrays lie one after the other in one compressed text.
const meta = JSON.parse(document.getElementById("meta").textContent)
const TYPES = {float32: Float32Array, int32: Int32Array, int16: Int16Array, uint8: Uint8Array}
const blocks = await unpacked(document.getElementById("content").textContent, meta.blocks)

async function unpacked(text, places) {
  const letters = atob(text), bytes = new Uint8Array(letters.length)
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k)
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))
  const buffer = await new Response(stream).arrayBuffer()
  const of = ({offset, type, shape}) => {
    const size = shape.reduce((product, length) => product * length, 1)
    return {values: new TYPES[type](buffer, offset, size), shape}
  }
  return Object.fromEntries(Object.entries(places).map(([name, place]) => [name, of(place)]))
}

// The part of a block at some indices of its first dimensions.
function part(name, ...indices) {
  const {values, shape} = blocks[name]
  const rest = shape.slice(indices.length).reduce((product, length) => product * length, 1)
  const start = indices.reduce((place, index, k) => place * shape[k] + index, 0) * rest
  return values.subarray(start, start + rest)
}

const fromLogarithm = (code) => (code === -32768 ? NaN : code === 32767 ? Infinity : 2 ** (code / meta.codes.log))
const fromExponent = (code) => (code === -32768 ? NaN : code / meta.codes.exponent)
const fromHeight = (code) => (code ? (meta.codes.least / 2) * 2 ** ((code - 1) / meta.codes.height) : NaN)

function within(name, ...indices) {
  const [low, high] = part(`${name}_ends`, ...indices)
  return Array.from(part(name, ...indices), (code) => (code ? low + ((code - 1) / 254) * (high - low) : NaN))
}

// Index of the value that is nearest in ratio.
function nearest(values, wanted) {
  const apart = values.map((value) => Math.abs(Math.log(value / wanted)))
  return apart.indexOf(Math.min(...apart))
}

// The map of one scheme at one cell: what came of that run.
function cellOf(p, s, i, j) {
  const at = (name) => part(name, p, s, i, j)[0]
  return {
    outcome: at("outcome"),
    began: at("began"),
    error: fromLogarithm(at("error")),
    iterations: at("iterations"),
    exponent: fromExponent(at("exponent")),
    u0: part("u0", p, i)[0],
    period: part("period", p, i)[0],
    step: meta.parts[j],
  }
}

// Samples of the run nearest to a cell. Times are in periods.
function samplesNear(p, s, i, j) {
  const {amplitudes, parts, every, earlyEvery} = meta.sampled
  const [a, b] = [nearest(amplitudes, meta.amplitudes[i]), nearest(parts, meta.parts[j])]
  return {
    u: within("late_u", p, s, a, b),
    v: within("late_v", p, s, a, b),
    height: Array.from(part("height", p, s, a, b), fromHeight),
    early: {u: within("early_u", p, s, a, b), v: within("early_v", p, s, a, b)},
    exact: {u: part("orbit_u", p, a), v: part("orbit_v", p, a)},
    spacing: every[b] * parts[b],
    earlySpacing: earlyEvery[b] * parts[b],
    everyStep: earlyEvery[b] === 1,
    periods: meta.periods,
    cell: {i: nearest(meta.amplitudes, amplitudes[a]), j: nearest(meta.parts, parts[b])},
  }
}

// Samples of one of the paper's own runs; undefined for a scheme that the paper does not have.
function samplesOfCase(k, scheme) {
  const one = meta.cases[k], ran = one.schemes[scheme]
  if (!ran) return undefined
  const of = (name) => Array.from(part(`case_${k}_${name}`, ran.place))
  const whole = (name) => part(`case_${k}_${name}`)
  return {
    u: of("late_u"),
    v: of("late_v"),
    height: of("height"),
    early: {u: of("early_u"), v: of("early_v")},
    exact: {u: whole("orbit_u"), v: whole("orbit_v")},
    spacing: (one.every * one.dt) / one.period,
    earlySpacing: one.dt / one.period,
    everyStep: true,
    periods: (one.steps * one.dt) / one.period,
  }
}
