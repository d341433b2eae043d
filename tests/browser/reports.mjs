// Opens reports that the program wrote in a headless Chromium: at the widths of a phone and a desk, on light and dark ground,
// and on paper; and searches the book. Usage: node reports.mjs PAM OUT CHROMIUM [BOOK]; OUT receives the reports and a
// picture of each view, BOOK is the folder of mdBook.

import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [pam, out, browserPath, book] = process.argv.slice(2).map((path) => resolve(path));
const root = resolve(dirname(fileURLToPath(import.meta.url)), "../..");
// Installed by .ci/browser.
const { chromium } = createRequire(join(root, "target/browser/"))("playwright-core");

let passed = 0;
const failures = [];
function check(holds, what) {
  if (holds) passed += 1;
  else failures.push(what);
}

// ---- Reports -----------------------------------------------------------------------------------------------------------

function makeReports() {
  mkdirSync(out, { recursive: true });
  const run = (...words) => execFileSync(pam, [...words, "--quiet"], { cwd: out, stdio: ["ignore", "ignore", "inherit"] });
  const weights = join(root, "data/published/hybrid_model_puresine_16.eqx");
  const measured = join(root, "data/published/data.mat");
  writeFileSync(join(out, "protocol.toml"), `name = "short"
conditions = [[30, 60], [60, 30], [45, 45], [80, 80], [55, 40], [40, 65]]
[[current]]
kind = "sine"
amplitude_a = 1.5
frequency_hz = 1.0
duration_s = 3.0
[[current]]
kind = "sine"
amplitude_a = 1.5
frequency_hz = 2.0
duration_s = 3.0
`);
  writeFileSync(join(out, "models.toml"), `name = "short comparison"
[data]
recordings = ["logs"]
train = ["3060", "6030", "4545", "8080"]
[[model]]
kind = "spring_damper"
[[model]]
kind = "koopman"
[[model]]
kind = "equilibrium_point"
`);
  writeFileSync(join(out, "curriculum.toml"), `name = "short"
[model]
hidden = [8]
[[stage]]
kind = "gas"
name = "gas"
[[stage]]
kind = "derivatives"
name = "derivatives"
matching = { steps = 200 }
[[stage]]
kind = "solve"
name = "solve"
epochs = 3
horizon_s = 0.5
`);
  const reports = {
    rig: () => run("rig", "record", "--ideal", "all", "--no-truth", "--protocol", "protocol.toml", "--out", "logs", "--report", "logs/report.html"),
    train: () => run("train", "curriculum.toml", "--data", "logs", "--out", "trained"),
    evaluate: () => run("evaluate", "--model", weights, "--data", measured, "--out", "evaluated"),
    compare: () => run("compare", "models.toml", "--out", "compared"),
    diagnose: () => run("diagnose", "--model", weights, "--data", measured, "--out", "diagnosed"),
  };
  const folders = { rig: "logs", train: "trained", evaluate: "evaluated", compare: "compared", diagnose: "diagnosed" };
  return Object.entries(reports).map(([name, make]) => {
    const path = join(out, folders[name], "report.html");
    if (!existsSync(path)) make();
    return { name, path };
  });
}

// ---- What is read in the page ------------------------------------------------------------------------------------------

// Text whose contrast with its ground is too small (WCAG 2.2, 1.4.3): 4.5, and 3 for large text.
function lowContrast() {
  const rgba = (text) => {
    const [r, g, b, a = 1] = text.match(/[\d.]+/g).map(Number);
    return { rgb: [r, g, b], a };
  };
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((c) => (c / 255 <= 0.04045 ? c / 3294.6 : ((c / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (node) => {
    const svg = node.closest("svg.figure");
    if (svg) return rgba(getComputedStyle(svg.querySelector(".ground")).color).rgb;
    for (let at = node; at; at = at.parentElement) {
      const colour = rgba(getComputedStyle(at).backgroundColor);
      if (colour.a > 0) return colour.rgb;
    }
    return [255, 255, 255];
  };
  const found = new Set();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text = walker.nextNode(); text; text = walker.nextNode()) {
    const node = text.parentElement;
    if (!text.data.trim() || node.closest("script, style, svg.schematic") || !node.getClientRects().length) continue;
    const style = getComputedStyle(node);
    if (style.visibility === "hidden") continue;
    const inSvg = Boolean(node.closest("svg"));
    const colour = rgba(inSvg ? style.fill : style.color).rgb;
    const [high, low] = [luminance(colour), luminance(ground(node))].sort((a, b) => b - a);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const ratio = (high + 0.05) / (low + 0.05);
    if (ratio < (large ? 3 : 4.5)) found.add(`${ratio.toFixed(2)}: ${text.data.trim().slice(0, 40)}`);
  }
  return [...found];
}

// Figures whose text is too small, leaves the figure, or lies on other text.
function badFigureText(least) {
  const found = new Set();
  for (const svg of document.querySelectorAll("svg.figure")) {
    const frame = svg.getBoundingClientRect();
    if (frame.width === 0) continue;
    const name = svg.getAttribute("aria-label");
    const texts = [...svg.querySelectorAll("text")].filter((t) => getComputedStyle(t).visibility !== "hidden" && t.textContent);
    const boxes = texts.map((t) => [t, t.getBoundingClientRect()]);
    for (const [text, box] of boxes) {
      const size = parseFloat(getComputedStyle(text).fontSize) * svg.getScreenCTM().a;
      if (size < least) found.add(`${name}: text of ${size.toFixed(1)} px`);
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) {
        found.add(`${name}: "${text.textContent}" leaves the figure`);
      }
    }
    for (let i = 0; i < boxes.length; i++) {
      for (let k = i + 1; k < boxes.length; k++) {
        const [a, b] = [boxes[i][1], boxes[k][1]];
        const overlap = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
          Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3;
        if (overlap) found.add(`${name}: "${boxes[i][0].textContent}" lies on "${boxes[k][0].textContent}"`);
      }
    }
  }
  return [...found];
}

const shownView = (svg) => svg.querySelector("svg.data").getAttribute("viewBox");
const overflow = () => document.documentElement.scrollWidth - document.documentElement.clientWidth;

// ---- Views -------------------------------------------------------------------------------------------------------------

const views = [
  { name: "phone", width: 375, height: 812, scheme: "light", touch: true },
  { name: "phone-dark", width: 375, height: 812, scheme: "dark", touch: true },
  { name: "desk", width: 1280, height: 900, scheme: "light", touch: false },
  { name: "desk-dark", width: 1280, height: 900, scheme: "dark", touch: false },
];

async function look(browser, report, view) {
  const context = await browser.newContext({
    viewport: { width: view.width, height: view.height }, colorScheme: view.scheme, hasTouch: view.touch,
  });
  const page = await context.newPage();
  const told = [];
  const where = `${report.name}, ${view.name}`;
  const address = pathToFileURL(report.path).href;
  page.on("console", (message) => told.push(message.text()));
  page.on("pageerror", (error) => told.push(String(error)));
  page.on("request", (request) => {
    if (request.url() !== address && !request.url().startsWith("data:")) told.push(`request of ${request.url()}`);
  });
  await page.goto(address);
  await page.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
  // The figures are laid out at their width after the next frame.
  await page.waitForTimeout(300);
  check((await page.evaluate(overflow)) <= 0, `${where}: the page is wider than the screen`);
  for (const text of await page.evaluate(lowContrast)) check(false, `${where}: contrast ${text}`);
  for (const text of await page.evaluate(badFigureText, 10)) check(false, `${where}: ${text}`);
  const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  check((ground === "rgb(255, 255, 255)") === (view.scheme === "light"), `${where}: ground ${ground}`);
  await page.screenshot({ path: join(out, `${report.name}-${view.name}.png`), fullPage: true });
  await magnify(page, context, where, view.touch);
  if (view.name === "desk-dark") {
    // Paper is light whatever the screen is.
    await page.pdf({ path: join(out, `${report.name}.pdf`), format: "A4", printBackground: true });
    await page.emulateMedia({ media: "print" });
    await page.setViewportSize({ width: 690, height: 900 });
    await page.waitForTimeout(300);
    const paper = await page.evaluate(() => getComputedStyle(document.body).color);
    check(paper === "rgb(34, 34, 34)", `${where}: text on paper is ${paper}`);
    check((await page.evaluate(overflow)) <= 0, `${where}: the page is wider than the paper`);
    for (const text of await page.evaluate(lowContrast)) check(false, `${where}, print: contrast ${text}`);
    for (const text of await page.evaluate(badFigureText, 8)) check(false, `${where}, print: ${text}`);
  }
  check(told.length === 0, `${where}: ${told.join("; ")}`);
  await context.close();
}

// The figure is magnified by every means, and each time shown whole again.
async function magnify(page, context, where, touch) {
  const figure = page.locator("svg.figure").first();
  if ((await figure.count()) === 0) return;
  const view = () => figure.evaluate(shownView);
  const ticks = () => figure.locator(".mesh text").allTextContents();
  const whole = await view();
  const firstTicks = await ticks();
  await figure.scrollIntoViewIfNeeded();
  const box = await figure.boundingBox();
  const [x, y] = [box.x + 0.55 * box.width, box.y + 0.5 * box.height];

  await figure.focus();
  await page.keyboard.press("+");
  check((await view()) !== whole, `${where}: the key + does not magnify`);
  check(JSON.stringify(await ticks()) !== JSON.stringify(firstTicks), `${where}: the axes do not follow`);
  const magnified = await view();
  await page.keyboard.press("ArrowLeft");
  check((await view()) !== magnified, `${where}: arrows do not move`);
  await page.keyboard.press("Escape");
  check((await view()) === whole, `${where}: Esc does not reset`);

  if (touch) {
    const client = await context.newCDPSession(page);
    const fingers = (type, ...points) =>
      client.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
    await fingers("touchStart", [x - 20, y], [x + 20, y]);
    for (const d of [30, 45, 60]) await fingers("touchMove", [x - d, y], [x + d, y]);
    await fingers("touchEnd");
    await page.waitForTimeout(100);
    check((await view()) !== whole, `${where}: a pinch does not magnify`);
    await figure.press("0");
  } else {
    await figure.evaluate((svg) => svg.blur());
    await page.mouse.move(x, y);
    const before = await page.evaluate(() => scrollY);
    await page.mouse.wheel(0, 60);
    await page.waitForTimeout(150);
    check((await view()) === whole, `${where}: the wheel magnifies a figure that is not selected`);
    const scrolled = (await page.evaluate(() => scrollY)) - before;
    await page.mouse.wheel(0, -scrolled);
    await page.waitForTimeout(150);
    await page.mouse.click(x, y);
    await page.mouse.wheel(0, -200);
    await page.waitForTimeout(100);
    const near = await view();
    check(near !== whole, `${where}: the wheel does not magnify`);
    await page.mouse.down();
    await page.mouse.move(x + 40, y + 10, { steps: 4 });
    await page.mouse.up();
    check((await view()) !== near, `${where}: dragging does not move`);
    await page.screenshot({ path: join(out, `${where.replace(", ", "-")}-zoomed.png`), clip: box });
    for (const text of await page.evaluate(badFigureText, 10)) check(false, `${where}, magnified: ${text}`);
    await page.mouse.dblclick(x, y);
  }
  check((await view()) === whole, `${where}: the figure is not reset`);
  check(JSON.stringify(await ticks()) === JSON.stringify(firstTicks), `${where}: the axes are not reset`);
}

// The search of the book finds pages, and its pages fit a phone.
async function search(browser) {
  const context = await browser.newContext({ viewport: { width: 375, height: 812 } });
  const page = await context.newPage();
  const told = [];
  page.on("pageerror", (error) => told.push(String(error)));
  page.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) told.push(`request of ${request.url()}`);
  });
  const address = (name) => pathToFileURL(join(book, name)).href;
  for (const [words, found] of [["dry friction", "friction"], ["gauge pressure", "gauge"], ["stiffness", "stiffness"]]) {
    await page.goto(address("index.html"));
    await page.keyboard.press("/");
    await page.keyboard.type(words);
    const results = page.locator("[id*=searchresults] li");
    const appeared = await results.first().waitFor({ timeout: 5000 }).then(() => true, () => false);
    const text = appeared ? (await results.allTextContents()).join(" ") : "";
    check(text.toLowerCase().includes(found), `book: nothing is found for "${words}"`);
  }
  for (const name of ["introduction.html", "diagnosis.html", "commands.html", "gallery.html"]) {
    await page.goto(address(name));
    check((await page.evaluate(overflow)) <= 0, `book, ${name}: the page is wider than a phone`);
  }
  check(told.length === 0, `book: ${told.join("; ")}`);
  await context.close();
}

const reports = makeReports();
const browser = await chromium.launch({
  executablePath: browserPath,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});
for (const report of reports) for (const view of views) await look(browser, report, view);
if (book && existsSync(join(book, "index.html"))) await search(browser);
await browser.close();
for (const failure of failures) console.log(`FAILED ${failure}`);
console.log(`${passed} passed, ${failures.length} failed`);
process.exitCode = failures.length ? 1 : 0;
