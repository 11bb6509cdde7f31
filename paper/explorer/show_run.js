
const nearest = (axis, place) => {
  const at = axis.length < 2 ? 0 : Math.round((place - axis[0]) / (axis[1] - axis[0]))
  return Math.min(Math.max(at, 0), axis.length - 1)
}
const at = cb_data.geometry ?? {x: place.data.x[0], y: place.data.y[0]}
const [i, j] = [nearest(y, at.y), nearest(x, at.x)]
const one = runs.data.name.indexOf(`${problem.value} ${scheme.value}`)
const of_run = (values, length, place) => Array.from({length}, (_, k) => values[place * length + k])
const [u, v, height] = ["u", "v", "height"].map((name) => of_run(runs.data[name][one], samples, i * x.length + j))
const p = orbits.data.problem.indexOf(problem.value)
const [orbit_u, orbit_v] = ["u", "v"].map((name) => of_run(orbits.data[name][p], points, i))
run.data = {u, v, height, t: u.map((_, sample) => sample * spacing[j]), sample: [...u.keys()]}
orbit.data = {u: orbit_u, v: orbit_v}
place.data = {x: [x[j]], y: [y[i]]}
const [u0, dt] = [orbits.data.u0[p][i], 10 ** x[j] * orbits.data.period[p][i]]
const ended = labels[runs.data.outcome[one][i * x.length + j]]
title.text = `u₀ = ${u0.toPrecision(3)}, Δt = ${dt.toPrecision(3)} = T/${(10 ** -x[j]).toPrecision(3)}: ${ended}`
