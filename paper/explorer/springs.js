// The springs of the maps, with a unit mass: force, its slope, potential energy, the energy at rest and the displacement
// of rest, and where a motion from rest at u0 turns back.
const cubic = (S1, S2) => ({
  force: (u) => S1 * u * (1 + S2 * u * u),
  slope: (u) => S1 * (1 + 3 * S2 * u * u),
  potential: (u) => 0.5 * S1 * u * u * (1 + 0.5 * S2 * u * u),
})
const SPRINGS = {
  hardening: {...cubic(100, 10), lowest: 0, rest: 0, turn: (u0) => -u0},
  softening: {
    force: (u) => 100 * Math.tanh(u),
    slope: (u) => 100 / Math.cosh(u) ** 2,
    potential: (u) => 100 * (Math.abs(u) + Math.log1p(Math.exp(-2 * Math.abs(u))) - Math.LN2),
    lowest: 0, rest: 0, turn: (u0) => -u0,
  },
  double_well: {
    ...cubic(-0.5, -1),
    lowest: -1 / 8,
    rest: 1,
    // below the barrier the motion stays in one well
    turn: (u0) => (u0 * u0 < 2 ? Math.sqrt(2 - u0 * u0) : -u0),
  },
}

// Exact period: the time between the turning points, by the midpoint rule in an angle at which it converges exponentially.
function periodOf({potential, turn}, u0, points = 4000) {
  const middle = (u0 + turn(u0)) / 2, half = (u0 - turn(u0)) / 2
  let sum = 0
  for (let k = 0; k < points; k++) {
    const angle = ((k + 0.5) * Math.PI) / points
    sum += Math.sin(angle) / Math.sqrt(2 * (potential(u0) - potential(middle + half * Math.cos(angle))))
  }
  return (2 * Math.PI * Math.abs(half) * sum) / points
}
