// Text and pictures of one run: its errors, its motion, its orbit, and its energy along time.
const SIZE = {width: 420, left: 46, right: 10, top: 10, bottom: 36}
const PERIODS = 6 // of the motion that is drawn
const DOTS = 2000 // of the orbit, about
const LIMITS = [0.01, 100] // of the energy that is drawn
const short = (value) => (Number.isFinite(value) ? String(+value.toPrecision(3)).replace("-", "−") : "–")
const stepName = (step) => (step >= 0.995 ? "T" : `T/${short(1 / step)}`)

// The chosen run by a scheme, with the exact motion over a period; undefined if the page has no such scheme.
function runOf(choice, s) {
  const scheme = SCHEMES[meta.schemes[s].name], spring = springOf(choice), {u0, step} = choice, period = periodAt(choice)
  if (!scheme) return undefined
  const steps = Math.round(meta.periods / step), run = march(spring, scheme, u0, step * period, steps)
  const failed = run.u.length <= steps
  return {
    ...run, step, failed,
    exact: march(spring, SCHEMES.kahan_li8, u0, period / 128, 128),
    energyError: failed ? NaN : 100 * run.height.reduce((most, one) => Math.max(most, Math.abs(one - 1)), 0),
    periodError: failed ? NaN : 100 * Math.abs(meanPeriod(run, spring.rest) / period - 1),
  }
}

// The mean time between passages upwards through a displacement.
function meanPeriod({u, h}, level) {
  const times = []
  for (let k = 1; k < u.length; k++)
    if (u[k - 1] < level && u[k] >= level) times.push((k - (u[k] - level) / (u[k] - u[k - 1])) * h)
  return (times.at(-1) - times[0]) / (times.length - 1)
}

// About five round numbers between two limits.
function ticksBetween(low, high) {
  const rough = (high - low) / 5, size = 10 ** Math.floor(Math.log10(rough))
  const step = [1, 2, 5, 10].map((n) => n * size).find((one) => one >= rough)
  const start = Math.ceil(low / step)
  return Array.from({length: Math.floor(high / step) - start + 1}, (_, k) => +((start + k) * step).toPrecision(12))
}

function panel(content, {x, y, xs, ys, xLabel, yLabel, height, title}) {
  const {width, left, right, top, bottom} = SIZE, floor = height - bottom
  const name = (value) => String(value).replace("-", "−")
  return `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${title}">
    ${xs.map((v) => `<path class="grid" d="M${x(v)} ${top}V${floor}"/>
      <text x="${x(v)}" y="${floor + 14}" text-anchor="middle">${name(v)}</text>`).join("")}
    ${ys.map((v) => `<path class="grid" d="M${left} ${y(v)}H${width - right}"/>
      <text x="${left - 5}" y="${y(v) + 4}" text-anchor="end">${name(v)}</text>`).join("")}
    <svg x="${left}" y="${top}" width="${width - left - right}" height="${floor - top}" overflow="hidden"
      viewBox="${left} ${top} ${width - left - right} ${floor - top}">${content}</svg>
    <rect class="axis" x="${left}" y="${top}" width="${width - left - right}" height="${floor - top}"/>
    <text x="${(left + width - right) / 2}" y="${height - 6}" text-anchor="middle">${xLabel}</text>
    <text transform="translate(10 ${(top + floor) / 2}) rotate(-90)" text-anchor="middle">${yLabel}</text></svg>`
}

const scale = ([low, high], from, to) => (value) => from + ((value - low) / (high - low)) * (to - from)
const pixel = (x) => within([-9999, 9999], x).toFixed(1)
const path = (xs, ys) => `M${xs.map((x, k) => `${pixel(x)} ${pixel(ys[k])}`).join("L")}`
const dots = (xs, ys) => xs.map((x, k) => `M${pixel(x)} ${pixel(ys[k])}h0`).join("")
const times = ({u, step}) => u.map((_, k) => k * step)

// Limits that hold the runs, but go no farther beyond the exact orbit, or its mirror image in the other well, than the
// width of the orbit, so that it stays of a size to be seen.
function limits(runs, name) {
  const most = (values) => values.reduce((a, b) => Math.max(a, b)), least = (values) => values.reduce((a, b) => Math.min(a, b))
  const {exact} = runs[0], [low, high] = [least(exact[name]), most(exact[name])], reach = high - low
  const from = Math.max(least([low, ...runs.map((run) => least(run[name]))]), Math.min(low, -high) - reach)
  const to = Math.min(most([high, ...runs.map((run) => most(run[name]))]), Math.max(high, -low) + reach)
  return [from - 0.06 * (to - from), to + 0.06 * (to - from)]
}

function motion(run, window, title) {
  const {width, left, right, top, bottom} = SIZE, height = 210, periods = Math.min(PERIODS, meta.periods)
  const x = scale([0, periods], left, width - right), y = scale(window.u, height - bottom, top)
  const shown = Math.floor(periods / run.step) + 2, {exact} = run
  const [xs, ys] = [times(run).slice(0, shown).map(x), run.u.slice(0, shown).map(y)]
  const around = Array.from({length: 128 * periods + 1}, (_, k) => k)
  const truth = path(around.map((k) => x(k / 128)), around.map((k) => y(exact.u[k % 128])))
  // the ends of steps are marked where they are so few that the line between them is not the motion
  const ends = run.step > 1 / 50 ? `<path class="dots" d="${dots(xs, ys)}"/>` : ""
  return panel(
    `<path class="exact" d="${truth}"/><path class="line" d="${path(xs, ys)}"/>${ends}`,
    {x, y, xs: ticksBetween(0, periods), ys: ticksBetween(...window.u), xLabel: "time, periods T", yLabel: "displacement u",
      height, title},
  )
}

function orbit(run, window, title) {
  const {width, left, right, top, bottom} = SIZE, height = 300
  const x = scale(window.u, left, width - right), y = scale(window.v, height - bottom, top)
  const every = Math.ceil(run.u.length / DOTS), kept = (_, k) => k % every === 0
  const [xs, ys] = [run.u.filter(kept).map(x), run.v.filter(kept).map(y)], quarter = Math.ceil(xs.length / 4)
  // dots from light to dark along time
  const parts = [0, 1, 2, 3].map((k) => [xs, ys].map((all) => all.slice(k * quarter, (k + 1) * quarter)))
  return panel(
    `<path class="exact" d="${path(run.exact.u.map(x), run.exact.v.map(y))}"/>
     ${parts.map(([xs, ys], k) => `<path class="dots" stroke-opacity="${0.25 * (k + 1)}" d="${dots(xs, ys)}"/>`).join("")}`,
    {x, y, xs: ticksBetween(...window.u), ys: ticksBetween(...window.v), xLabel: "displacement u", yLabel: "velocity u̇",
      height, title},
  )
}

function energy(run, title) {
  const {width, left, right, top, bottom} = SIZE, height = 190, [least, most] = LIMITS
  const x = scale([0, meta.periods], left, width - right)
  const logarithmic = scale([Math.log10(least / 1.6), Math.log10(1.6 * most)], height - bottom, top)
  const y = (value) => logarithmic(Math.log10(within([least / 2, 2 * most], value)))
  return panel(
    `<path class="level" d="M0 ${y(1)}H${width}"/><path class="line" d="${path(times(run).map(x), run.height.map(y))}"/>`,
    {x, y, xs: ticksBetween(0, meta.periods), ys: [0.01, 0.1, 1, 10, 100], xLabel: "time, periods T",
      yLabel: "energy / start's", height, title},
  )
}

function drawn(run, window, title) {
  const figure = (svg, caption) => `<figure>${svg}<figcaption>${caption}</figcaption></figure>`
  const start = `The first ${Math.min(PERIODS, meta.periods)} periods. Grey: exact.`
  return `<div>${figure(motion(run, window, `motion by ${title}`), start)}
    ${figure(energy(run, `energy by ${title}`), "Energy above rest over that at the start.")}</div>
    ${figure(orbit(run, window, `orbit by ${title}`), "Orbit of the whole run, from light to dark. Grey: exact.")}`
}

// Summary of a run: its errors next to the allowed one, and the class of its cell.
function summary(choice, s, run) {
  const {i, j, u0, step, exact} = cellOf(choice), outcome = part("outcome", choice.problem, s, i, j)[0]
  const verdict = (error) => `${error < 0.001 ? "below 0.001" : short(error)} %, ${error <= choice.error ? "✓ within" : "✗ not within"} ${choice.error} %`
  const rows = run
    ? run.failed
      ? `<p><b>✗ The run fails</b> in step ${run.u.length}, after ${short(run.u.length * run.step)} periods.</p>`
      : `<dl><dt>largest energy error</dt><dd>${verdict(run.energyError)}</dd>
        <dt>error of the period</dt><dd>${verdict(run.periodError)}</dd></dl>`
    : "<p>The page does not compute runs of this scheme.</p>"
  const cell = exact ? "" : `Nearest cell of the map, u₀ = ${short(u0)}, Δt = ${stepName(step)}: `
  return `<p class="place">u₀ = ${short(choice.u0)}, Δt = ${short(choice.step * periodAt(choice))} =
    ${stepName(choice.step)}</p>${rows}
    <p data-class="${outcome}">${cell}<b>${meta.outcomes[outcome].label}</b>: ${meta.outcomes[outcome].note}</p>`
}
