// Runs the page of `quoin report` without a browser: a document of stubs, three.js as it is but for what draws.
// Usage: node page.js REPORT.html. Writes JSON: what the page shows of every run, frame and colour.
'use strict';
const fs = require('fs'), vm = require('vm');
const html = fs.readFileSync(process.argv[2], 'utf8');

class Element {
  constructor(tag) {
    Object.assign(this, {tag, style: {}, children: [], listeners: {}, dataset: {}, value: '', checked: false});
    Object.assign(this, {clientWidth: 800, clientHeight: 600, attributes: {}});
  }
  appendChild(child) { this.children.push(child); return child; }
  removeChild(child) { this.children.splice(this.children.indexOf(child), 1); }
  get firstChild() { return this.children[0]; }
  setAttribute(name, value) { this.attributes[name] = String(value); }
  addEventListener(type, act) { (this.listeners[type] = this.listeners[type] || []).push(act); }
  removeEventListener() {}
  send(type) { for (const act of this.listeners[type] || []) act({}); }
  set textContent(text) { this.text = String(text); this.children = []; }
  get textContent() { return this.text || ''; }
}
const byId = {};
for (const [, tag, attributes] of html.matchAll(/<(\w+)((?: [^<>]*)? id="[^<>]*)>/g)) {
  const element = byId[/ id="([^"]*)"/.exec(attributes)[1]] = new Element(tag);
  element.checked = / checked/.test(attributes);
  const value = / value="([^"]*)"/.exec(attributes);
  if (value) element.value = value[1];
}
const choices = id => [...new RegExp(`id="${id}">([^]*?)</select>`).exec(html)[1].matchAll(/<option value="([^"]*)"/g)].map(m => m[1]);
const options = choices('colour');
byId.colour.value = options[0]; byId.range.value = choices('range')[0];
const scripts = [...html.matchAll(/<script((?: [^>]*)?)>([\s\S]*?)<\/script>/g)];
const ofClass = name => scripts.filter(s => s[1].includes(`class="${name}"`)).map(s => ({textContent: s[2]}));
const body = new Element('body');
globalThis.window = globalThis.self = globalThis;
globalThis.location = {hash: ''};
globalThis.addEventListener = () => {};
globalThis.requestAnimationFrame = act => setTimeout(act, 0);
globalThis.document = {
  body, createElement: tag => new Element(tag), createElementNS: (_, tag) => new Element(tag),
  getElementById: id => byId[id], addEventListener() {}, removeEventListener() {},
  querySelectorAll: selector => selector.includes('.') ? ofClass(selector.split('.')[1]) : []
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
const marksOf = (drawing, name) => drawing.children.filter(c => c.attributes.class === name);
function shown({model, curves}) {
  const words = marksOf(model.overlay, 'crack').filter(c => c.tag === 'text').map(c => c.textContent);
  const paints = marksOf(model.overlay, 'crack').filter(c => c.tag === 'rect').map(c => c.attributes.fill);
  return {frame: model.frame, position: numbers(model.position), colour: numbers(model.colour), cracked: model.cracked,
    rim: Array.from(Float32Array.from(model.cracks.at)), rim_colour: model.cracks.paint,
    points: model.cracks.points, point_colour: model.cracks.tints,
    legend: words.map((word, k) => [word, paints[k]]), quantity: marksOf(model.overlay, 'legend')[0].textContent,
    range: [model.shown.low, model.shown.high], loads: model.forces.parts.filter(p => p.colour === model.forces.loadColour).map(p => p.to),
    dots: curves.map(c => c.dots.map(d => [Number(d.attributes.cx), Number(d.attributes.cy)]))};
}
function whenReady() {
  if (!body.dataset.ready) return setTimeout(whenReady, 5);
  const told = {ready: body.dataset.ready, fault: texts(body).join(' '), options, runs: []};
  for (const run of body.dataset.ready === 'yes' ? quoinRuns : []) {
    const of_run = {natural: Number(byId.magnification.value), vertices: run.model.vertices, looks: [],
      curves: run.curves.map(c => ({xs: c.xs, lines: c.lines, labels: c.labels, width: c.width, top: c.top,
        strokes: marksOf(c.svg, 'curve').map(m => m.attributes.points.split(' ').map(p => p.split(',').map(Number)))})),
      texts: texts(byId.runs), robust: Object.fromEntries(options.map(what => [what, quoinBar.ranges.robust(what)]))};
    byId.range.value = 'whole';
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
