// The map of one scheme: cells on a canvas, axes and marks above them.
const MARGIN = {left: 50, right: 8, top: 8, bottom: 38}
const STEPS = [100, 50, 20, 10, 5, 2, 1]

// Places of the edges of cells whose middles are evenly spaced in the logarithm.
function edgesOf(values) {
  const logs = values.map(Math.log10), half = (logs.at(-1) - logs[0]) / (logs.length - 1) / 2
  return [logs[0] - half, logs.at(-1) + half]
}

function frameOf(width, choice) {
  const [left, right] = edgesOf(meta.steps), [low, high] = edgesOf(amplitudesOf(choice))
  const height = Math.round(Math.min(Math.max(0.6 * width, 240), 430))
  // a page that is not on a screen has no width
  const inner = {width: Math.max(width - MARGIN.left - MARGIN.right, 1), height: height - MARGIN.top - MARGIN.bottom}
  const at = (part, {length}) => within([0, length - 1], Math.floor(part * length))
  return {
    width, height, inner, low, high,
    x: (step) => MARGIN.left + ((Math.log10(step) - left) / (right - left)) * inner.width,
    y: (u0) => MARGIN.top + ((high - Math.log10(u0)) / (high - low)) * inner.height,
    runAt: (x, y) => ({
      step: meta.steps[at((x - MARGIN.left) / inner.width, meta.steps)],
      u0: amplitudesOf(choice)[at(1 - (y - MARGIN.top) / inner.height, meta.amplitudes)],
    }),
  }
}

function drawCells(canvas, {inner}, {colour, problem}, s) {
  const ratio = devicePixelRatio || 1
  canvas.style.cssText = `left:${MARGIN.left}px;top:${MARGIN.top}px;width:${inner.width}px;height:${inner.height}px`
  canvas.width = Math.round(inner.width * ratio)
  canvas.height = Math.round(inner.height * ratio)
  const pen = canvas.getContext("2d"), of = classesOf(colour, problem, s)
  const [rows, columns] = [meta.amplitudes.length, meta.steps.length]
  // edges fall on whole pixels, so that no background shines through between two cells
  const edge = (k, count, size) => Math.round((k * size) / count)
  classesFor(colour).forEach((one, k) => {
    if (!of.includes(k)) return
    pen.beginPath()
    for (let place = 0; place < of.length; place++) {
      if (of[place] !== k) continue
      const [i, j] = [Math.floor(place / columns), place % columns]
      const [x, y] = [edge(j, columns, canvas.width), edge(rows - 1 - i, rows, canvas.height)]
      pen.rect(x, y, edge(j + 1, columns, canvas.width) - x, edge(rows - i, rows, canvas.height) - y)
    }
    fillAs(pen, one, () => pen.fill())
  })
}

function axes({x, y, inner, low, high, height}) {
  const bottom = MARGIN.top + inner.height, right = MARGIN.left + inner.width
  const ticks = STEPS.map((n) => {
    const at = x(1 / n)
    return `<path class="axis" d="M${at} ${bottom}v5"/>
      <text x="${at}" y="${bottom + 17}" text-anchor="middle">${n === 1 ? "T" : `T/${n}`}</text>`
  })
  for (let power = Math.ceil(low); power <= high; power++) {
    const at = y(10 ** power)
    ticks.push(`<path class="axis" d="M${MARGIN.left} ${at}h-5"/>
      <text x="${MARGIN.left - 8}" y="${at + 4}" text-anchor="end">${10 ** power}</text>`)
  }
  return `${ticks.join("")}
    <rect class="axis" x="${MARGIN.left}" y="${MARGIN.top}" width="${inner.width}" height="${inner.height}"/>
    <path class="twenty" d="M${x(1 / 20)} ${MARGIN.top}V${bottom}"/>
    <text x="${(MARGIN.left + right) / 2}" y="${height - 4}" text-anchor="middle">step size Δt</text>
    <text transform="translate(11 ${MARGIN.top + inner.height / 2}) rotate(-90)" text-anchor="middle">amplitude u₀</text>`
}

const STAR = Array.from({length: 10}, (_, k) => {
  const [angle, radius] = [(Math.PI * k) / 5 - Math.PI / 2, k % 2 ? 3.6 : 9]
  return `${(radius * Math.cos(angle)).toFixed(2)},${(radius * Math.sin(angle)).toFixed(2)}`
}).join(" ")

// The runs of the paper, the chosen one, and the largest safe step of its amplitude.
function marks({x, y}, choice, side) {
  const double = (shape) => `<g stroke-width="4" class="halo">${shape}</g><g stroke-width="1.8" class="over">${shape}</g>`
  const {i, u0} = cellOf(choice), safe = safeStep(choice, choice.schemes[side], i)
  const bar = safe > 0 ? double(`<path d="M${MARGIN.left} ${y(u0)}H${x(safe)}m0 -6v12"/>`) : ""
  const stars = meta.cases.filter((one) => one.problem === meta.problems[choice.problem].name).map(({u0, dt}) => `<polygon
    class="star" points="${STAR}" transform="translate(${x(dt / periodAt({...choice, u0}))} ${y(u0)})"/>`)
  return `${bar}${stars.join("")}${double(`<circle cx="${x(choice.step)}" cy="${y(choice.u0)}" r="10"/>`)}`
}
