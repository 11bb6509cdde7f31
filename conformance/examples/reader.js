// Reads a case and judges a run, as an example for a code in another language: node reader.js CASE.json
const fs = require("fs");

// Newmark's method with beta > 0 on a linear oscillator
function newmark({ problem, scheme, run }) {
  const [m, c, k] = [problem.mass, problem.damping, problem.parameters.stiffness].map((matrix) => Number(matrix[0][0]));
  const [beta, gamma, dt] = [scheme.beta, scheme.gamma, run.dt].map(Number);
  const { amplitude, frequency, phase } = problem.load ?? { amplitude: ["0"], frequency: "0", phase: "0" };
  const load = (t) => Number(amplitude[0]) * Math.cos(Number(frequency) * t - Number(phase));
  let [u, v] = [Number(problem.u0[0]), Number(problem.v0[0])];
  let a = (load(0) - c * v - k * u) / m;
  const rows = { u: [u], v: [v], a: [a] };
  for (let i = 1; i <= run.steps; i++) {
    const ahead = u + dt * v + dt * dt * (0.5 - beta) * a;
    const faster = v + dt * (1 - gamma) * a;
    a = (load(i * dt) - c * faster - k * ahead) / (m + gamma * dt * c + beta * dt * dt * k);
    [u, v] = [ahead + beta * dt * dt * a, faster + gamma * dt * a];
    rows.u.push(u), rows.v.push(v), rows.a.push(a);
  }
  return rows;
}

const test = JSON.parse(fs.readFileSync(process.argv[2], "utf-8"));
const known = test.tags.includes("newmark") && test.tags.includes("linear") && test.problem.u0.length === 1;
if (!known || test.problem.ground || test.run.sizes || test.expect[0].kind !== "identical") console.log(`${test.name}: skip`), process.exit(77);
const found = newmark(test);
const off = test.expect.filter(({ quantity, at, values, tolerance }) =>
  values.some((value, i) => !(Math.abs(found[quantity][at[i]] - Number(value)) <= Number(tolerance))));
console.log(`${test.name}: ${off.length ? `fail, ${off.map((one) => one.quantity).join(", ")} differ` : "pass"}`);
process.exit(off.length ? 1 : 0);
