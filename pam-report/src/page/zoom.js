// Figures that can be magnified, and that are laid out at the width they have. A figure is an SVG of this program: its
// content is drawn in UNITS between the axes, and its data- attributes hold the ranges of the axes.
(() => {
  "use strict";
  const UNITS = 20000, LEFT = 76, BELOW = 48, RIGHT = 16, ROW = 20, ABOVE = 8, TITLE_GAP = 14, GAP = 14;
  const LEAST = 1 / 200; // of an axis is still shown
  const number = (node, name) => Number(node.dataset[name]);

  function axis(text) {
    const [low, high, scale] = text.split(" ");
    return { low: Number(low), high: Number(high), log: scale === "log" };
  }

  // Round numbers at distances of 1, 2 or 5 times a power of ten.
  function linearMarks(low, high, count) {
    const rough = (high - low) / count;
    const power = 10 ** Math.floor(Math.log10(rough));
    const distance = [1, 2, 5, 10].map((f) => f * power).find((d) => d >= 0.999 * rough) ?? rough;
    const marks = [];
    for (let k = Math.ceil(low / distance); k <= Math.floor(high / distance); k++) {
      marks.push([k * distance, linearLabel(k * distance, distance)]);
    }
    return marks;
  }

  function linearLabel(value, distance) {
    if (Math.abs(value) < 1e-9 * distance) return "0";
    const place = Math.floor(Math.log10(distance) + 1e-9);
    const size = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
    const text = size >= 5 || place < -4
      ? value.toExponential(Math.min(20, Math.max(0, size - place))).replace(/\.?0*e\+?/, "e")
      : value.toFixed(Math.max(0, -place));
    return text.replace(/-/g, "−");
  }

  // Powers of ten; with 2 and 5 times them where there are few; ordinary numbers within one decade.
  function logMarks(low, high, count) {
    const decades = Math.floor(high) - Math.ceil(low) + 1;
    const marks = [];
    if (decades >= 3) {
      const every = Math.floor(decades / count) + 1;
      for (let k = Math.ceil(low / every) * every; k <= high; k += every) marks.push([k, power(k, 1)]);
      return marks;
    }
    for (let k = Math.floor(low); k <= Math.ceil(high); k++) {
      for (const factor of [1, 2, 5]) {
        const place = k + Math.log10(factor);
        if (place >= low && place <= high) marks.push([place, power(k, factor)]);
      }
    }
    if (marks.length > 1) return marks;
    return linearMarks(10 ** low, 10 ** high, count).map(([v, text]) => [Math.log10(v), text]);
  }

  function power(exponent, factor) {
    if (exponent >= -3 && exponent <= 4) return String(Number((factor * 10 ** exponent).toPrecision(3)));
    const raised = String(exponent).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)]));
    return factor === 1 ? `10${raised}` : `${factor}·10${raised}`;
  }

  const marks = (a, low, high, count) =>
    (a.log ? logMarks : linearMarks)(low, high, Math.max(2, Math.floor(count)));

  function zoomable(svg) {
    const axes = { x: axis(svg.dataset.x), y: axis(svg.dataset.y) };
    const right = number(svg, "right");
    const height = Number(svg.getAttribute("height"));
    const find = (selector) => [...svg.querySelectorAll(selector)];
    const [mesh] = find(".mesh"), data = find("svg.data"), moved = find("[data-at]"), entries = find(".entry");
    const cut = data.map((d) => d.getAttribute("overflow"));
    const whole = { x: 0, y: 0, width: UNITS, height: UNITS };
    let width = Number(svg.getAttribute("width")), view = { ...whole }, plot;

    // The legend in as many rows as it needs, the first beside the title; returns the rows.
    function legend() {
      const [title] = find(".title");
      const room = width - RIGHT - LEFT;
      if (!title && entries.length === 0) return 0.2;
      const rows = [[]];
      let left = room - (title ? number(title, "width") + TITLE_GAP : 0);
      for (const entry of entries) {
        const needed = number(entry, "width") + GAP;
        if (needed > left && (rows.length > 1 || left < room)) {
          rows.push([]);
          left = room;
        }
        left -= needed;
        rows.at(-1).push(entry);
      }
      rows.forEach((row, k) => {
        const length = row.reduce((sum, e) => sum + number(e, "width") + GAP, -GAP);
        let at = Math.max(LEFT, width - RIGHT - length);
        for (const entry of row) {
          entry.setAttribute("transform", `translate(${at} ${ABOVE + ROW * k + 6.5})`);
          at += number(entry, "width") + GAP;
        }
      });
      return rows.length;
    }

    function draw() {
      const top = ABOVE + ROW * legend();
      plot = { x: LEFT, y: top, width: Math.max(1, width - LEFT - right), height: Math.max(1, height - top - BELOW) };
      svg.setAttribute("width", width); // its ratio to the height is that of the figure on the page
      svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      data.forEach((d, k) => {
        for (const name of ["x", "y", "width", "height"]) d.setAttribute(name, plot[name]);
        d.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
        d.setAttribute("overflow", isWhole() ? cut[k] : "hidden");
      });
      const scale = `scale(${view.width / plot.width} ${view.height / plot.height})`;
      for (const mark of moved) mark.setAttribute("transform", `translate(${mark.dataset.at}) ${scale}`);
      const [x, y] = [find(".x-label")[0], find(".y-label")[0]];
      x.setAttribute("x", plot.x + plot.width / 2);
      const long = number(y, "width") > plot.height; // longer than its axis: about the middle of the figure
      y.setAttribute("transform", `translate(15 ${long ? height / 2 : plot.y + plot.height / 2}) rotate(-90)`);
      find(".beside")[0].setAttribute("transform", `translate(${width - right} 0)`);
      for (const label of find(".band-label")) {
        const place = (v) => Math.min(1, Math.max(0, (v - view.x) / view.width)) * plot.width;
        const [from, to] = [place(number(label, "from")), place(number(label, "to"))];
        label.setAttribute("x", plot.x + (from + to) / 2);
        label.setAttribute("y", plot.y + 14);
        label.setAttribute("visibility", to - from > number(label, "width") ? "visible" : "hidden");
      }
      drawMesh();
      svg.classList.toggle("zoomed", !isWhole());
    }

    function drawMesh() {
      const place = (a, share) => a.low + share * (a.high - a.low);
      const range = {
        x: [place(axes.x, view.x / UNITS), place(axes.x, (view.x + view.width) / UNITS)],
        y: [place(axes.y, 1 - (view.y + view.height) / UNITS), place(axes.y, 1 - view.y / UNITS)],
      };
      const bottom = plot.y + plot.height;
      let grid = "", texts = "";
      for (const [v, text] of marks(axes.x, ...range.x, plot.width / 75)) {
        const at = plot.x + ((v - range.x[0]) / (range.x[1] - range.x[0])) * plot.width;
        grid += `M${at} ${plot.y}V${bottom}`;
        texts += `<text x="${at}" y="${bottom + 17}" text-anchor="middle" fill="currentColor">${text}</text>`;
      }
      for (const [v, text] of marks(axes.y, ...range.y, plot.height / 38)) {
        const at = bottom - ((v - range.y[0]) / (range.y[1] - range.y[0])) * plot.height;
        grid += `M${plot.x} ${at}h${plot.width}`;
        texts += `<text x="${plot.x - 8}" y="${at + 4.5}" text-anchor="end" fill="currentColor">${text}</text>`;
      }
      const line = (name, d) => `<g class="${name}"><path d="${d}" fill="none" stroke="currentColor"/></g>`;
      mesh.innerHTML = line("grid", grid) + line("ink", `M${plot.x} ${plot.y}V${bottom}h${plot.width}`) +
        `<g class="ink">${texts}</g>`;
    }

    const isWhole = () => view.width === UNITS && view.height === UNITS;

    function show(next) {
      const within = (v, size) => Math.min(UNITS - size, Math.max(0, v));
      view = { width: Math.min(UNITS, next.width), height: Math.min(UNITS, next.height) };
      view.x = within(next.x, view.width);
      view.y = within(next.y, view.height);
      draw();
    }

    // Magnifies about a place, given in shares of the plot.
    function zoom(fx, fy, sx = 0.5, sy = 0.5) {
      const limit = (size) => Math.min(UNITS, Math.max(LEAST * UNITS, size));
      const next = { width: limit(view.width / fx), height: limit(view.height / fy) };
      next.x = view.x + sx * (view.width - next.width);
      next.y = view.y + sy * (view.height - next.height);
      show(next);
    }

    function pan(dx, dy) {
      show({ ...view, x: view.x - dx * view.width, y: view.y - dy * view.height });
    }

    // Shares of the plot at a place of the screen.
    function shares(event) {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      return { x: (p.x - plot.x) / plot.width, y: (p.y - plot.y) / plot.height };
    }

    svg.addEventListener("wheel", (event) => {
      // An unselected figure leaves the wheel to the page.
      if (document.activeElement !== svg && !event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      const at = shares(event);
      const factor = Math.exp(-0.0022 * (event.deltaY || event.deltaX));
      zoom(event.altKey ? 1 : factor, event.shiftKey ? 1 : factor, at.x, at.y);
    }, { passive: false });

    const fingers = new Map();
    svg.addEventListener("pointerdown", (event) => {
      svg.focus({ preventScroll: true });
      fingers.set(event.pointerId, shares(event));
      if (!isWhole() || fingers.size > 1) svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = shares(event);
      fingers.set(event.pointerId, now);
      if (fingers.size === 1) {
        if (!isWhole()) pan(now.x - before.x, now.y - before.y);
        return;
      }
      const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
      const apart = (p) => Math.hypot((p.x - other.x) * plot.width, (p.y - other.y) * plot.height);
      const factor = apart(now) / Math.max(1, apart(before));
      zoom(factor, factor, (now.x + other.x) / 2, (now.y + other.y) / 2);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      svg.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    svg.addEventListener("dblclick", () => show(whole));
    svg.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const step = 0.2;
      const actions = {
        "+": () => zoom(1.5, 1.5), "=": () => zoom(1.5, 1.5), "-": () => zoom(1 / 1.5, 1 / 1.5),
        "0": () => show(whole), Escape: () => show(whole),
        ArrowLeft: () => pan(step, 0), ArrowRight: () => pan(-step, 0),
        ArrowUp: () => pan(0, step), ArrowDown: () => pan(0, -step),
      };
      // Arrows scroll the page while the figure is whole.
      if (!actions[event.key] || (event.key.startsWith("Arrow") && isWhole())) return;
      event.preventDefault();
      actions[event.key]();
    });

    function fit() {
      const shown = svg.parentElement.clientWidth;
      if (shown > 0 && Math.abs(shown - width) >= 1) {
        width = Math.max(240, shown);
        draw();
      }
    }
    svg.tabIndex = 0;
    svg.setAttribute("aria-roledescription", "zoomable figure");
    draw();
    new ResizeObserver(fit).observe(svg.parentElement);
    addEventListener("beforeprint", () => {
      // Shares of the width of A4.
      width = svg.closest(".three") ? 260 : svg.closest(".grid") ? 340 : 690;
      draw();
    });
    addEventListener("afterprint", fit);
  }

  const figures = document.querySelectorAll("figure svg.figure");
  figures.forEach(zoomable);
  for (const hint of document.querySelectorAll(".hint")) hint.hidden = figures.length === 0;
  // Tables that scroll can be reached by keyboard.
  for (const box of document.querySelectorAll(".scroll")) if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
  // Paper shows what a screen folds away.
  addEventListener("beforeprint", () => {
    for (const d of document.querySelectorAll("details:not([open])")) { d.open = true; d.dataset.folded = ""; }
  });
  addEventListener("afterprint", () => {
    for (const d of document.querySelectorAll("details[data-folded]")) { d.open = false; delete d.dataset.folded; }
  });
})();
