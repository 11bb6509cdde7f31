// The page: choices, two maps, and what is told of the chosen run by both schemes.
const $ = (selector, within = document) => within.querySelector(selector)
const sides = [0, 1].map((side) => ({
  map: $(`.map[data-side="${side}"]`), run: $(`.run[data-side="${side}"]`), canvas: null, frame: null, overlay: null,
}))
let choice = choiceOf(location.hash)
let looked = null // the run beneath the mouse, or that the arrows have reached
const shownRun = () => looked ?? choice.run

function fill(select, list, value) {
  select.replaceChildren(...list.map(([name, title]) => new Option(title, name, false, name === String(value))))
}

// Keep a choice, and put it into the address.
function keep(change) {
  choice = ofProblem({...choice, ...change})
  looked = null
  history.replaceState(null, "", addressOf(choice))
  drawAll()
}

function look(run) {
  if (run && looked && sameRun(run, looked)) return
  looked = run
  requestAnimationFrame(drawShown)
}

function build() {
  $("#problem").onchange = ({target}) => keep({problem: Number(target.value)})
  $("#colour").onchange = ({target}) => keep({colour: target.value})
  sides.forEach((one, side) => {
    one.run.innerHTML = `<div aria-live="polite"></div><div></div>`
    one.map.innerHTML = `<select aria-label="scheme"></select><div class="plane" tabindex="0" role="application"
      aria-roledescription="map of runs"><canvas></canvas><svg aria-hidden="true"><g></g><g></g></svg></div>`
    $("select", one.map).onchange = ({target}) =>
      keep({schemes: choice.schemes.map((s, k) => (k === side ? Number(target.value) : s))})
    one.plane = $(".plane", one.map)
    one.canvas = $("canvas", one.map)
    one.overlay = $("svg", one.map)
    const at = (event) => {
      const {left, top} = one.plane.getBoundingClientRect()
      return runAt(event.clientX - left, event.clientY - top, choice.problem, one.frame)
    }
    one.plane.onpointermove = (event) => event.pointerType === "mouse" && look(at(event))
    one.plane.onpointerleave = () => look(null)
    one.plane.onblur = () => look(null)
    one.plane.onclick = (event) => keep({run: at(event)})
    one.plane.onkeydown = onKey
  })
  new ResizeObserver(drawAll).observe($(".sides"))
  matchMedia("(prefers-color-scheme: dark)").onchange = drawAll
  addEventListener("hashchange", () => { choice = choiceOf(location.hash); looked = null; drawAll() })
}

const ARROWS = {ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [1, 0], ArrowDown: [-1, 0]}
function onKey(event) {
  const move = ARROWS[event.key], by = event.shiftKey ? 5 : 1, {i, j} = shownRun()
  if (move) look(cellRun(i + by * move[0], j + by * move[1]))
  else if (event.key === "Enter") keep({run: shownRun()})
  else if (event.key === "Escape") look(null)
  else return
  event.preventDefault()
}

function drawLegend() {
  const here = choice.colour === "outcome"
    ? sides.map((_, side) => part("outcome", choice.problem, choice.schemes[side], shownRun().i, shownRun().j)[0]) : []
  const list = document.createElement("ul")
  CLASSES[choice.colour].forEach((one, k) => {
    const item = document.createElement("li")
    if (here.includes(k)) item.dataset.here = ""
    item.append(swatch(one))
    item.insertAdjacentHTML("beforeend", `<span>${one.label}${one.note ? `<small>: ${one.note}</small>` : ""}</span>`)
    list.append(item)
  })
  $(".legend").replaceChildren(list)
}

// Everything, after a change of the choice or of the size.
function drawAll() {
  fill($("#problem"), meta.problems.map(({title}, p) => [String(p), title]), choice.problem)
  fill($("#colour"), Object.entries(COLOURS), choice.colour)
  const titles = choice.schemes.map((s) => meta.schemes[s].title), problem = meta.problems[choice.problem].title
  $("#shown").textContent = `${problem[0].toUpperCase()}${problem.slice(1)}, ${meta.periods} periods: ${titles.join(", ")}`
  document.title = `${titles.join(", ")}: where can they be trusted on the ${problem}?`
  $("#cases").replaceChildren(...meta.cases.map((one, k) => {
    const button = document.createElement("button")
    button.textContent = `★ ${meta.problems[indexOf(meta.problems, one.problem)].title}, u₀ = ${short(one.u0)}`
    button.ariaPressed = String(choice.run.case === k)
    button.onclick = () => keep({problem: indexOf(meta.problems, one.problem), run: caseRun(k)})
    return button
  }))
  sides.forEach((one, side) => {
    fill($("select", one.map), meta.schemes.map(({title}, s) => [String(s), title]), choice.schemes[side])
    one.plane.setAttribute("aria-label", `${titles[side]}: ${COLOURS[choice.colour]} over step size and amplitude`)
    one.frame = frameOf(one.map.clientWidth, choice.problem)
    one.plane.style.height = `${one.frame.height}px`
    one.overlay.setAttribute("width", one.frame.width)
    one.overlay.setAttribute("height", one.frame.height)
    drawCells(one.canvas, one.frame, choice.colour, choice.problem, choice.schemes[side])
    one.overlay.firstChild.innerHTML = axes(one.frame)
  })
  drawShown()
}

// What follows the mouse: marks, and what is told of the run.
function drawShown() {
  const run = shownRun(), p = choice.problem
  const samples = choice.schemes.map((s) => samplesOf(run, p, s))
  const window = {u: limits(samples, "u"), v: limits(samples, "v")}
  sides.forEach((one, side) => {
    one.overlay.lastChild.innerHTML = marks(one.frame, choice, run, side)
    const [told, figures] = one.run.children
    told.innerHTML = sentences(run, p, choice.schemes[side], samples[side], window)
    const ending = $("[data-class]", told)
    ending.prepend(swatch(CLASSES.outcome[ending.dataset.class]))
    figures.innerHTML = drawn(run, p, choice.schemes[side], samples[side], window)
  })
  drawLegend()
}

// The cell whose run the samples are of, if it is another than the chosen one.
function elsewhere(run, p, s, {cell}) {
  return cell && (cell.i !== run.i || cell.j !== run.j) && cellOf(p, s, cell.i, cell.j)
}

function sentences(run, p, s, samples, window) {
  const cell = cellOf(p, s, run.i, run.j), one = meta.cases[run.case], ran = one?.schemes[meta.schemes[s].name]
  const near = elsewhere(run, p, s, samples)
  const lost = samples.u.filter((u, k) => Number.isFinite(samples.height[k]) && !inside(u, samples.v[k], window)).length
  const notes = [
    one && !ran && "The paper has no run of this scheme; told is that of the nearest cell.",
    near && `Samples are kept of some runs; orbit and energy are those of the nearest, u₀ = ${short(near.u0)},
      Δt = ${stepName(near.step)}, ${ended(near.outcome)}.`,
    lost && `${lost} of the dots lie outside of the panel.`,
  ].filter(Boolean)
  return `${ran ? `${toldOfCase(one, ran)}<p class="note">The nearest run of the map:</p>` : ""}${toldOfCell(cell)}
    <p class="safe">${safeSentence(p, s, run.i)}</p>${notes.map((note) => `<p class="note">${note}</p>`).join("")}`
}

function drawn(run, p, s, samples, window) {
  const {title} = meta.schemes[s], cell = cellOf(p, s, run.i, run.j)
  const own = samples.cell && !elsewhere(run, p, s, samples)
  const began = own && cell.began >= 0 ? cell.began * cell.step : -1
  const steps = samples.everyStep ? "every step" : "samples closer than T/20"
  return `<figure>${orbit(samples, window, `orbit by ${title}`)}<figcaption>Orbit. Dashed: exact. Line: the first
    ${short(beginning(samples) * samples.earlySpacing)} periods, ${steps}. Dots: the whole run, one each
    ${short(samples.spacing)} periods, from light to dark.</figcaption></figure>
    <figure>${energy(samples, began, `energy by ${title}`)}<figcaption>Energy above rest over that at the start; dotted
    the limits of rest and growth${began >= 0 ? ", and when it began" : ""}.</figcaption></figure>`
}

const inside = (u, v, window) =>
  u >= window.u[0] && u <= window.u[1] && v >= window.v[0] && v <= window.v[1]

build()
drawAll()
document.documentElement.dataset.ready = ""
