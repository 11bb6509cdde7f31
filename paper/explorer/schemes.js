// The schemes on a spring of unit mass without damping and load: `step` takes the state {u, v, a} one h on, and a scheme
// of several steps makes its memory in `start`.

// The acceleration a with a + weight p(u + c a) = right, by Newton's iteration. Where that fails it starts again with a
// safeguard: once two accelerations have residuals of opposite signs, it bisects where a correction leaves them or is
// not half of the last one; before, it goes twice as far as last. NaN where that fails too.
function balance(p, u, c, guess, weight = 1, right = 0, safely = false) {
  let a = guess, negative = -Infinity, positive = Infinity, last = Infinity
  for (let k = 0; k < (safely ? 100 : 50); k++) {
    const residual = a + weight * p.force(u + c * a) - right
    let change = -residual / (1 + weight * c * p.slope(u + c * a))
    if (residual < 0) negative = a
    else positive = a
    if (safely) {
      const leaves = (a + change - negative) * (a + change - positive) > 0
      const crawls = !(Math.abs(change) <= Math.abs(last) / 2)
      if (!Number.isFinite(positive - negative)) change = crawls ? -2 * Math.sign(residual) * Math.abs(last) : change
      else if (leaves || crawls) change = (negative + positive) / 2 - a
    }
    a += change
    if (!Number.isFinite(a)) break
    if (Math.abs(c * change) <= 1e-12 * (Math.abs(u) + Math.abs(c * a))) return a
    last = change
  }
  return safely ? NaN : balance(p, u, c, guess, weight, right, true)
}

const newmark = (beta, gamma, alpha = 0) => (p, {u, v, a}, h) => {
  const predicted = u + h * v + h * h * (0.5 - beta) * a
  const after = balance(p, predicted, beta * h * h, a, 1 + alpha, alpha * p.force(u))
  return {u: predicted + beta * h * h * after, v: v + h * ((1 - gamma) * a + gamma * after), a: after}
}

const wilson = (theta) => (p, {u, v, a}, h) => {
  const tau = theta * h
  const ahead = balance(p, u + tau * v + (tau * tau * a) / 3, (tau * tau) / 6, a)
  const after = a + (ahead - a) / theta
  return {u: u + h * v + h * h * (a / 3 + after / 6), v: v + (h * (a + after)) / 2, a: after}
}

const houbolt = (p, {u, a, u1, u2}, h) => {
  const predicted = (5 * u - 4 * u1 + u2) / 2, after = balance(p, predicted, (h * h) / 2, a)
  const v = (11 * predicted - 18 * u + 9 * u1 - 2 * u2) / (6 * h) + (11 * h * after) / 12
  return {u: predicted + (h * h * after) / 2, v, a: after, u1: u, u2: u1}
}

// The fictitious points make the first step a step of the linear acceleration method.
function houboltStart(p, {u, v, a}, h) {
  const first = newmark(1 / 6, 0.5)(p, {u, v, a}, h), u1 = h * h * a - first.u + 2 * u
  return {u, v, a, u1, u2: 6 * h * v - 2 * first.u - 3 * u + 6 * u1}
}

// Backward differences; average acceleration, run backwards, finds the motion before the start.
const backward = (first, ...rest) => ({
  start(p, now, h) {
    const older = rest.slice(1).reduce((past) => [...past, newmark(1 / 4, 1 / 2)(p, past.at(-1), -h)], [now])
    return {...now, older: older.slice(1)}
  },
  step(p, {u, v, a, older}, h) {
    const past = [{u, v}, ...older], c = h / first
    const from = (name) => -rest.reduce((sum, weight, k) => sum + weight * past[k][name], 0) / first
    const [du, dv] = [from("u") + c * from("v"), from("v")], after = balance(p, du, c * c, a)
    return {u: du + c * c * after, v: dv + c * after, a: after, older: past.slice(0, -1)}
  },
})

const generalized = (alphaM, alphaF) => {
  const gamma = 0.5 - alphaM + alphaF, beta = (0.5 + gamma) ** 2 / 4, part = 1 - alphaF, scale = 1 / (1 - alphaM)
  return (p, {u, v, a}, h) => {
    const du = h * v + h * h * (0.5 - beta * scale) * a
    const middle = balance(p, u + part * du, part * beta * scale * h * h, a)
    return {
      u: u + du + beta * scale * h * h * middle,
      v: v + h * ((1 - gamma * scale) * a + gamma * scale * middle),
      a: scale * (middle - alphaM * a),
    }
  }
}

const bathe = (gamma, rho) => {
  const q1 = (1 + rho) / (2 * gamma * (rho - 1) + 4), q0 = (gamma - 1) * q1 + 0.5, q2 = 0.5 - gamma * q1
  return (p, {u, v, a}, h) => {
    const k = (gamma * h) / 2, c = q2 * h
    const middle = balance(p, u + 2 * k * v + k * k * a, k * k, a)
    const dv = h * (q0 * a + q1 * middle)
    const du = h * (q0 * v + q1 * (v + k * (a + middle))) + c * (v + dv)
    const after = balance(p, u + du, c * c, middle)
    return {u: u + du + c * c * after, v: v + dv + c * after, a: after}
  }
}

// Schemes with a mean force between u and u₁: its value and slope as functions of u₁.
const meanForce = (between) => (p, {u, v, a}, h) => {
  const mean = balance(between(p, u), u + h * v, (h * h) / 2, a)
  return {u: u + h * v + (h * h * mean) / 2, v: v + h * mean, a: mean}
}

const midpoint = ({force, slope}, u) => ({
  force: (after) => force((u + after) / 2),
  slope: (after) => slope((u + after) / 2) / 2,
})

// The quotient of energies, and the force at the middle where displacements are too close for it.
const energyMomentum = (p, u) => {
  const middle = midpoint(p, u), near = (after) => Math.abs(after - u) <= 1e-5 * Math.hypot(u, after)
  const quotient = (after) => (p.potential(after) - p.potential(u)) / (after - u)
  return {
    force: (after) => (near(after) ? middle.force(after) : quotient(after)),
    slope: (after) => (near(after) ? middle.slope(after) : (p.force(after) - quotient(after)) / (after - u)),
  }
}

// The mean force at three points of Gauss between u and u₁.
const meanField = ({force, slope}, u) => {
  const mean = (of) => [[-Math.sqrt(0.6), 5 / 18], [0, 8 / 18], [Math.sqrt(0.6), 5 / 18]].reduce(
    (sum, [node, weight]) => sum + weight * of((1 + node) / 2), 0)
  return {
    force: (after) => mean((s) => force(u + s * (after - u))),
    slope: (after) => mean((s) => s * slope(u + s * (after - u))),
  }
}

// The two stages of Gauss' method by Newton's iteration for both.
const GAUSS = [[1 / 4, 1 / 4 - Math.sqrt(3) / 6], [1 / 4 + Math.sqrt(3) / 6, 1 / 4]]
const SQUARED = GAUSS.map((row) => [0, 1].map((j) => row[0] * GAUSS[0][j] + row[1] * GAUSS[1][j]))
const TIMES = GAUSS.map(([one, other]) => one + other)
const gauss = (p, {u, v, a, stages: [a1, a2] = [a, a]}, h) => {
  for (let k = 0; k < 50; k++) {
    const at = SQUARED.map(([one, other], i) => u + TIMES[i] * h * v + h * h * (one * a1 + other * a2))
    const [r1, r2] = [a1 + p.force(at[0]), a2 + p.force(at[1])]
    const [[m11, m12], [m21, m22]] = SQUARED.map((row, i) =>
      row.map((weight, j) => (i === j ? 1 : 0) + weight * h * h * p.slope(at[i])))
    const det = m11 * m22 - m12 * m21, d1 = (m22 * r1 - m12 * r2) / det, d2 = (m11 * r2 - m21 * r1) / det
    a1 -= d1
    a2 -= d2
    if (!(h * h * Math.hypot(d1, d2) > 1e-13 * (Math.abs(u) + h * h * Math.hypot(a1, a2)))) {
      const du = h * v + (h * h * ((1 - TIMES[0]) * a1 + (1 - TIMES[1]) * a2)) / 2
      return {u: u + du, v: v + (h * (a1 + a2)) / 2, stages: [a1, a2]}
    }
  }
  return {u: NaN, v: NaN}
}

const rungeKutta = (p, {u, v}, h) => {
  const k = (du, dv) => [h * (v + dv), -h * p.force(u + du)]
  const [u1, v1] = k(0, 0), [u2, v2] = k(u1 / 2, v1 / 2), [u3, v3] = k(u2 / 2, v2 / 2), [u4, v4] = k(u3, v3)
  return {u: u + (u1 + u4) / 6 + (u2 + u3) / 3, v: v + (v1 + v4) / 6 + (v2 + v3) / 3}
}

const nystrom = ({force}, {u, v}, h) => {
  const k1 = -force(u), k2 = -force(u + (h * v) / 2 + (h * h * k1) / 8), k4 = -force(u + h * v + (h * h * k2) / 2)
  return {u: u + h * v + (h * h * (k1 + 2 * k2)) / 6, v: v + (h * (k1 + 4 * k2 + k4)) / 6}
}

// A drift, and then kicks and drifts in turn.
const splitting = (first, ...pairs) => ({force}, {u, v}, h) => {
  u += first * h * v
  for (const [kick, drift] of pairs) {
    v -= kick * h * force(u)
    u += drift * h * v
  }
  return {u, v}
}

const explicitAlpha = (alphaM, beta, gamma) => ({force}, {u, v, a}, h) => {
  const after = (-force(u) - alphaM * a) / (1 - alphaM)
  return {u: u + h * v + h * h * ((0.5 - beta) * a + beta * after), v: v + h * ((1 - gamma) * a + gamma * after), a: after}
}

const nohBathe = (part) => {
  const q1 = (1 - 2 * part) / (2 * part * (1 - part)), q2 = 0.5 - part * q1, q0 = 0.5 - q1 - q2
  return ({force}, {u, v, a}, h) => {
    const k = (1 - part) * h, middle = u + part * h * (v + (part * h * a) / 2), between = -force(middle)
    const speed = v + (part * h * (a + between)) / 2
    u = middle + k * (speed + (k * between) / 2)
    const after = -force(u)
    return {u, v: speed + k * (q0 * a + (0.5 + q1) * between + q2 * after), a: after}
  }
}

const tchamwa = (phi) => ({force}, {u, v, a}, h) => {
  const after = u + h * v + phi * h * h * a
  return {u: after, v: v + h * a, a: -force(after)}
}

// The model is the spring as it is undeformed.
const kolayRicles = (rho) => {
  const alphaM = (2 * rho - 1) / (rho + 1), alphaF = rho / (rho + 1), gamma = 0.5 - alphaM + alphaF
  return ({force, slope}, {u, v, a}, h) => {
    const model = ((0.5 + gamma) ** 2 / 4) * h * h * slope(0), step = a / (1 + model)
    const du = h * v + (0.5 + gamma) * h * h * step, middle = -force(u + (1 - alphaF) * du)
    const after = ((1 + model) * middle - (alphaM + alphaF * model) * a) / (1 - alphaM + (1 - alphaF) * model)
    return {u: u + du, v: v + h * step, a: after}
  }
}

// Velocity Verlet steps of some lengths, the same from both ends; the middle one makes their sum one.
const composition = (...half) => {
  const middle = 1 - 2 * half.reduce((sum, weight) => sum + weight, 0)
  return (p, state, h) =>
    [...half, middle, ...half.toReversed()].reduce((at, weight) => newmark(0, 0.5)(p, at, weight * h), state)
}

// Velocity Verlet with n = 1, 2, ... steps, extrapolated to steps of no length.
const extrapolation = (...counts) => (p, state, h) => {
  let u = 0, v = 0
  for (const n of counts) {
    const weight = counts.reduce((product, m) => (m === n ? product : (product * n * n) / (n * n - m * m)), 1)
    let at = state
    for (let k = 0; k < n; k++) at = newmark(0, 0.5)(p, at, h / n)
    u += weight * at.u
    v += weight * at.v
  }
  return {u, v, a: -p.force(u)}
}

// The weights of McLachlan's method.
const [OUTER, INNER, FIRST, SECOND] = [0.40518861839525227722, -0.28714404081652408900, -3 / 73, 17 / 59]
const CENTRE = 0.5 - OUTER - INNER
const SCHEMES = {
  average_acceleration: {step: newmark(1 / 4, 1 / 2)},
  central_difference: {step: newmark(0, 1 / 2)},
  newmark_dissipative: {step: newmark(0.3025, 0.6)},
  linear_acceleration: {step: newmark(1 / 6, 1 / 2)},
  fox_goodwin: {step: newmark(1 / 12, 1 / 2)},
  wilson_theta: {step: wilson(1.4)},
  houbolt: {step: houbolt, start: houboltStart},
  hht_alpha_1996: {step: newmark(0.3025, 0.6, -0.1)},
  hht_alpha: {step: generalized(0, 0.1)},
  wbz_alpha: {step: generalized(-0.2 / 1.8, 0)},
  generalized_alpha: {step: generalized(0.6 / 1.8, 0.8 / 1.8)},
  bdf2: backward(3 / 2, -2, 1 / 2),
  park: backward(10 / 6, -15 / 6, 1, -1 / 6),
  bathe: {step: bathe(0.5, 0)},
  rho_bathe: {step: bathe((2 - Math.sqrt(3)) / 0.5, 0.5)},
  tr_bdf2: {step: bathe(2 - Math.SQRT2, 0)},
  implicit_midpoint: {step: meanForce(midpoint)},
  energy_momentum: {step: meanForce(energyMomentum)},
  average_vector_field: {step: meanForce(meanField)},
  gauss4: {step: gauss},
  rk4: {step: rungeKutta},
  nystrom4: {step: nystrom},
  extrapolation12: {step: extrapolation(1, 2, 3, 4, 5, 6)},
  kr_alpha: {step: kolayRicles(0.8)},
  chung_lee: {step: explicitAlpha(0, 28 / 27, 1.5)},
  hulbert_chung: {step: explicitAlpha(1 / 3, 2.6 / (1.8 ** 2 * 1.2), 1.5 - 1 / 3)},
  noh_bathe: {step: nohBathe(0.54)},
  tchamwa_wielgosz: {step: tchamwa(1.033)},
  symplectic_euler: {step: splitting(0, [1, 1])},
  mclachlan4: {step: splitting(OUTER, [FIRST, INNER], [SECOND, CENTRE], [1 - 2 * (FIRST + SECOND), CENTRE],
    [SECOND, INNER], [FIRST, OUTER])},
  yoshida4: {step: composition(1 / (2 - Math.cbrt(2)))},
  yoshida6: {step: composition(0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695)},
  kahan_li8: {step: composition(
    0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
    -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887)},
}

// A run from rest at u0: displacements, velocities, and energies above rest over that at the start. It ends before a
// step at which no balance is found or the displacement leaves all bounds.
function march(p, {start = (p, state) => state, step}, u0, h, steps) {
  const u = [], v = [], height = [], above = (u, v) => (v * v) / 2 + p.potential(u) - p.lowest
  let state = start(p, {u: u0, v: 0, a: -p.force(u0)}, h)
  for (let k = 0; k <= steps && Math.abs(state.u) <= 1e9 * Math.abs(u0) && Number.isFinite(state.v); k++) {
    u.push(state.u)
    v.push(state.v)
    height.push(above(state.u, state.v) / above(u0, 0))
    state = step(p, state, h)
  }
  return {u, v, height, h}
}
