// The schemes on a spring of unit mass without damping and load: `step` takes the state {u, v, a} one h on, and a scheme
// of several steps makes its memory in `start`.

// The acceleration a with a + weight p(u + c a) = right, by Newton's iteration, which bisects between two accelerations
// with residuals of opposite signs where a correction leaves them or does not halve; NaN where it does not converge.
function balance({force, slope}, u, c, guess, weight = 1, right = 0) {
  let a = guess, negative = -Infinity, positive = Infinity, last = Infinity
  for (let k = 0; k < 50; k++) {
    const residual = a + weight * force(u + c * a) - right
    if (residual < 0) negative = a
    else positive = a
    let change = -residual / (1 + weight * c * slope(u + c * a))
    const leaves = (a + change - negative) * (a + change - positive) > 0
    if (Number.isFinite(positive - negative) && (leaves || Math.abs(change) > Math.abs(last) / 2))
      change = (negative + positive) / 2 - a
    a += change
    if (!(Math.abs(c * change) > 1e-12 * (Math.abs(u) + Math.abs(c * a)))) return a
    last = change
  }
  return NaN
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

// The fictitious points make the first step that of the linear acceleration method.
function houboltStart(p, {u, v, a}, h) {
  const first = newmark(1 / 6, 0.5)(p, {u, v, a}, h), u1 = h * h * a - first.u + 2 * u
  return {u, v, a, u1, u2: 6 * h * v - 2 * first.u - 3 * u + 6 * u1}
}

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

const rungeKutta = (p, {u, v}, h) => {
  const k = (du, dv) => [h * (v + dv), -h * p.force(u + du)]
  const [u1, v1] = k(0, 0), [u2, v2] = k(u1 / 2, v1 / 2), [u3, v3] = k(u2 / 2, v2 / 2), [u4, v4] = k(u3, v3)
  return {u: u + (u1 + u4) / 6 + (u2 + u3) / 3, v: v + (v1 + v4) / 6 + (v2 + v3) / 3}
}

// Velocity Verlet steps of some lengths, the same from both ends; the middle one makes their sum one.
const composition = (...half) => {
  const middle = 1 - 2 * half.reduce((sum, weight) => sum + weight, 0)
  return (p, state, h) =>
    [...half, middle, ...half.toReversed()].reduce((at, weight) => newmark(0, 0.5)(p, at, weight * h), state)
}

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
  bathe: {step: bathe(0.5, 0)},
  rho_bathe: {step: bathe((2 - Math.sqrt(3)) / 0.5, 0.5)},
  tr_bdf2: {step: bathe(2 - Math.SQRT2, 0)},
  implicit_midpoint: {step: meanForce(midpoint)},
  energy_momentum: {step: meanForce(energyMomentum)},
  rk4: {step: rungeKutta},
  yoshida4: {step: composition(1 / (2 - Math.cbrt(2)))},
  yoshida6: {step: composition(0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695)},
  kahan_li8: {step: composition(
    0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
    -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887)},
}

// A run from rest at u0: displacements, velocities, and energies above rest over that at the start. It ends before a
// step at which numbers overflow or Newton's iteration does not converge.
function march(p, {start = (p, state) => state, step}, u0, h, steps) {
  const u = [], v = [], height = [], above = (u, v) => (v * v) / 2 + p.potential(u) - p.lowest
  let state = start(p, {u: u0, v: 0, a: -p.force(u0)}, h)
  for (let k = 0; k <= steps && Number.isFinite(state.u) && Number.isFinite(state.v); k++) {
    u.push(state.u)
    v.push(state.v)
    height.push(above(state.u, state.v) / above(u0, 0))
    state = step(p, state, h)
  }
  return {u, v, height, h}
}
