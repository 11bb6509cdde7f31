// What is told and drawn of one run: how it ended, its orbit, and its energy along time.
const SIZE = {width: 420, height: 300, left: 46, right: 10, top: 10, bottom: 36}
const short = (value) => (Number.isFinite(value) ? String(+value.toPrecision(3)).replace("-", "−") : "–")
const stepName = (step) => (step >= 0.995 && step < 1.005 ? "T" : `T/${short(1 / step)}`)
const ended = (outcome) => meta.outcomes[outcome].label

function samplesOf(run, p, s) {
  return (run.case !== undefined && samplesOfCase(run.case, meta.schemes[s].name)) || samplesNear(p, s, run.i, run.j)
}

// About five round numbers between two limits.
function ticksBetween(low, high) {
  const rough = (high - low) / 5, size = 10 ** Math.floor(Math.log10(rough))
  const step = [1, 2, 5, 10].map((n) => n * size).find((one) => one >= rough)
  const start = Math.ceil(low / step)
  return Array.from({length: Math.floor(high / step) - start + 1}, (_, k) => +((start + k) * step).toPrecision(12))
}

function panel(content, {x, y, xs, ys, xLabel, yLabel, height = SIZE.height, title}) {
  const {width, left, right, top, bottom} = SIZE, floor = height - bottom
  const name = (value) => String(value).replace("-", "−")
  return `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${title}">
    ${xs.map((v) => `<path class="grid" d="M${x(v)} ${top}V${floor}"/>
      <text x="${x(v)}" y="${floor + 14}" text-anchor="middle">${name(v)}</text>`).join("")}
    ${ys.map((v) => `<path class="grid" d="M${left} ${y(v)}H${width - right}"/>
      <text x="${left - 5}" y="${y(v) + 4}" text-anchor="end">${name(v)}</text>`).join("")}
    <svg x="${left}" y="${top}" width="${width - left - right}" height="${floor - top}" overflow="hidden"
      viewBox="${left} ${top} ${width - left - right} ${floor - top}" style="overflow:hidden">${content}</svg>
    <rect class="axis" x="${left}" y="${top}" width="${width - left - right}" height="${floor - top}"/>
    <text x="${(left + width - right) / 2}" y="${height - 6}" text-anchor="middle">${xLabel}</text>
    <text transform="translate(10 ${(top + floor) / 2}) rotate(-90)" text-anchor="middle">${yLabel}</text></svg>`
}

function path(xs, ys) {
  let pen = "M"
  return Array.from(xs, (x, k) => {
    if (!Number.isFinite(x) || !Number.isFinite(ys[k])) { pen = "M"; return "" }
    const point = `${pen}${x.toFixed(1)} ${ys[k].toFixed(1)}`
    pen = "L"
    return point
  }).join("")
}

// Dots from light to dark along time.
const dots = (xs, ys) => Array.from(xs, (x, k) => (Number.isFinite(x) && Number.isFinite(ys[k])
  ? `<circle class="dot" cx="${x.toFixed(1)}" cy="${ys[k].toFixed(1)}" r="2.8"
      fill-opacity="${(0.12 + (0.88 * k) / xs.length).toFixed(2)}"/>` : "")).join("")

// Limits that hold the runs, but go no farther beyond the exact orbit, or its mirror image in the other well, than the
// width of the orbit, so that it stays of a size to be seen.
function limits(all, name) {
  const exact = all.flatMap((one) => Array.from(one.exact[name]))
  const [low, high] = [Math.min(...exact), Math.max(...exact)], reach = high - low
  const drawn = (one) => [...one[name], ...one.early[name].slice(0, beginning(one) + 1)]
  const values = all.flatMap(drawn).filter(Number.isFinite)
  const from = Math.max(Math.min(low, ...values), Math.min(low, -high) - reach)
  const to = Math.min(Math.max(high, ...values), Math.max(high, -low) + reach)
  return [from - 0.06 * (to - from), to + 0.06 * (to - from)]
}

function scale([low, high], from, to) {
  return (value) => from + ((value - low) / (high - low)) * (to - from)
}

// Samples of the line: three periods, or twenty steps where these take longer.
function beginning({early, earlySpacing}) {
  const there = early.u.filter(Number.isFinite).length - 1
  return Math.max(0, Math.min(there, Math.max(20, Math.ceil(3 / earlySpacing))))
}

function orbit(samples, window, title) {
  const {width, height, left, right, top, bottom} = SIZE
  const x = scale(window.u, left, width - right), y = scale(window.v, height - bottom, top)
  const {u, v, early, exact} = samples, shown = beginning(samples) + 1
  const line = [early.u.slice(0, shown).map(x), early.v.slice(0, shown).map(y)]
  const around = path(Array.from(exact.u, x), Array.from(exact.v, y))
  // the ends of steps are marked where they are so few that the line between them is not the motion
  const steps = samples.everyStep && samples.earlySpacing > 1 / 32
    ? line[0].map((at, k) => (Number.isFinite(at) && Number.isFinite(line[1][k])
      ? `<circle class="line" cx="${at.toFixed(1)}" cy="${line[1][k].toFixed(1)}" r="1.6"/>` : "")).join("") : ""
  return panel(
    `<path class="line" d="${path(...line)}"/>${steps}${dots(u.map(x), v.map(y))}
     <path class="behind" d="${around}"/><path class="exact" d="${around}"/>`,
    {x, y, xs: ticksBetween(...window.u), ys: ticksBetween(...window.v), xLabel: "displacement u", yLabel: "velocity u̇",
      title},
  )
}

function energy(samples, began, title) {
  const {width, left, right, top, bottom} = SIZE, height = 190, {least, most} = meta.codes
  const x = scale([0, samples.periods], left, width - right)
  const y = (h) => scale([Math.log10(least / 1.6), Math.log10(1.6 * most)], height - bottom, top)(Math.log10(h))
  const xs = samples.height.map((_, k) => x(k * samples.spacing)), ys = samples.height.map(y)
  const beginning = began >= 0 ? `<path class="level" d="M${x(began)} 0V${height}"/>` : ""
  return panel(
    `<path class="level" d="M0 ${y(least)}H${width}M0 ${y(most)}H${width}"/>${beginning}
     <path class="line" d="${path(xs, ys)}"/>${dots(xs, ys)}`,
    {x, y, xs: ticksBetween(0, samples.periods), ys: [0.01, 0.1, 1, 10, 100], xLabel: "time, periods T",
      yLabel: "energy / start's", height, title},
  )
}

function safeSentence(p, s, i) {
  const [accurate, bounded] = ["accurate", "bounded"].map((name) => part(`largest_${name}`, p, s, i)[0])
  const [u0, period] = [part("u0", p, i)[0], part("period", p, i)[0]]
  const at = (step) => `Δt = ${short(step * period)} = ${stepName(step)}`
  const found = accurate > 0
    ? `<b>Largest safe step at u₀ = ${short(u0)}: ${at(accurate)}.</b> At this and all finer steps of the map the run is
      ${ended(0)}.`
    : `<b>No safe step at u₀ = ${short(u0)}</b>: even the finest of the map, ${stepName(meta.parts[0])}, is not ${ended(0)}.`
  return bounded > (accurate || 0) ? `${found} Up to ${stepName(bounded)} it is at least ${ended(1)}.` : found
}

// Rows of a list of terms.
const terms = (rows) => `<dl>${rows.map(([term, text]) => `<dt>${term}</dt><dd>${text}</dd>`).join("")}</dl>`

const place = (u0, dt, step) => `<p class="place">u₀ = ${short(u0)}, Δt = ${short(dt)} = ${stepName(step)}</p>`

// What came of a run of the map, from its cell.
function toldOfCell(cell) {
  const what = meta.outcomes[cell.outcome]
  const rows = []
  if (cell.began >= 0) rows.push(["began at", `step ${cell.began}, after ${short(cell.began * cell.step)} periods`])
  rows.push(["largest energy error", Number.isNaN(cell.error) ? "–" : `${short(cell.error)} %`])
  if (cell.iterations) rows.push(["most Newton iterations", cell.iterations])
  rows.push(["Lyapunov exponent × T", short(cell.exponent)])
  return `${place(cell.u0, cell.step * cell.period, cell.step)}
    <p data-class="${cell.outcome}"><b>${what.label}</b>: ${what.note}</p>${terms(rows)}`
}

// What came of one of the paper's own runs.
function toldOfCase(one, ran) {
  const periods = (one.steps * one.dt) / one.period
  const end = ran.failed < 0 ? "completed" : `failed at step ${ran.failed}`
  return `${place(one.u0, one.dt, one.dt / one.period)}<p>★ The run of 1996: ${one.steps} steps, ${short(periods)} periods,
    ${end}; largest energy error ${short(ran.error)} %.</p>`
}
