// Runs the page of `quoin report` without a browser: a document of stubs, three.js as it is but for what draws.
// Usage: node page.js REPORT.html. Writes JSON: what the page shows of every run, frame and colour.
'use strict';
const fs = require('fs'), vm = require('vm');
const html = fs.readFileSync(process.argv[2], 'utf8');

class Element {
  constructor(tag) {
    Object.assign(this, {tag, style: {}, children: [], listeners: {}, dataset: {}, value: '', checked: false});
    Object.assign(this, {clientWidth: 800, clientHeight: 600, strokes: [], texts: []});
  }
  appendChild(child) { this.children.push(child); return child; }
  addEventListener(type, act) { (this.listeners[type] = this.listeners[type] || []).push(act); }
  removeEventListener() {}
  send(type) { for (const act of this.listeners[type] || []) act({}); }
  set textContent(text) { this.text = String(text); this.children = []; }
  get textContent() { return this.text || ''; }
  // Keeps what is written and the lines that are drawn.
  getContext() {
    const canvas = this;
    let path = [];
    return {
      clearRect() { canvas.strokes = []; canvas.texts = []; },
      beginPath() { path = []; }, moveTo(...p) { path.push(p); }, lineTo(...p) { path.push(p); }, arc() {}, fill() {},
      stroke() { canvas.strokes.push(path); }, fillText(text, x, y) { canvas.texts.push([text, x, y]); }
    };
  }
}
const byId = {};
for (const [, tag, attributes] of html.matchAll(/<(\w+)((?: [^<>]*)? id="[^<>]*)>/g)) {
  const element = byId[/ id="([^"]*)"/.exec(attributes)[1]] = new Element(tag);
  element.checked = / checked/.test(attributes);
  const value = / value="([^"]*)"/.exec(attributes);
  if (value) element.value = value[1];
}
const options = [...html.matchAll(/<option value="([^"]*)"/g)].map(m => m[1]);
byId.colour.value = options[0];
const scripts = [...html.matchAll(/<script((?: [^>]*)?)>([\s\S]*?)<\/script>/g)];
const ofClass = name => scripts.filter(s => s[1].includes(`class="${name}"`)).map(s => ({textContent: s[2]}));
const body = new Element('body');
globalThis.window = globalThis.self = globalThis;
globalThis.location = {hash: ''};
globalThis.addEventListener = () => {};
globalThis.document = {
  body, createElement: tag => new Element(tag), createElementNS: (_, tag) => new Element(tag),
  getElementById: id => byId[id], addEventListener() {}, removeEventListener() {},
  querySelectorAll: selector => ofClass(selector.split('.')[1])
};
const [library, page] = scripts.filter(s => !s[1]).map(s => s[2]);
vm.runInThisContext(library, 'three.js');
THREE.WebGLRenderer = class {
  constructor() { this.domElement = new Element('canvas'); }
  setClearColor() {}
  setPixelRatio() {}
  setSize() {}
  render() {}
};
vm.runInThisContext(page, 'script.js');

const numbers = attribute => attribute ? Array.from(attribute.array) : [];
const texts = element => [element.textContent, ...element.children.flatMap(texts)];
function shown(run) {
  return {frame: run.frame, position: numbers(run.position), colour: numbers(run.colour), cracked: run.cracked,
    rim: numbers(run.rim.geometry.attributes.position), rim_colour: numbers(run.rim.geometry.attributes.color),
    points: numbers(run.dots.geometry.attributes.position), point_colour: numbers(run.dots.geometry.attributes.color),
    legend: run.legend.children.map(c => [c.textContent, c.style.color || c.style.background]),
    dots: [run.curve.dots, run.energies.dots]};
}
function whenReady() {
  if (!body.dataset.ready) return setTimeout(whenReady, 5);
  const told = {ready: body.dataset.ready, fault: texts(body).join(' '), options, runs: []};
  for (const run of body.dataset.ready === 'yes' ? quoinRuns : []) {
    const of_run = {natural: Number(byId.magnification.value), vertices: run.vertices, looks: [],
      curves: [run.curve, run.energies].map(c => ({xs: c.xs, lines: c.lines, labels: c.labels, strokes: c.canvas.strokes,
        texts: c.canvas.texts, top: c.top})), texts: texts(byId.runs)};
    for (const magnified of [1, 50]) {
      byId.magnification.value = magnified;
      for (let f = 0; f < run.frames; ++f) {
        byId.time.value = f;
        for (const what of options) {
          byId.colour.value = what;
          byId.time.send('input');
          of_run.looks.push({magnified, what, ...shown(run)});
        }
      }
    }
    told.runs.push(of_run);
  }
  process.stdout.write(JSON.stringify(told));
}
whenReady();
