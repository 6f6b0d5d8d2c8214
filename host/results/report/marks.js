'use strict';
// Texts, numbers and SVG elements shared by model and curves.

const QUANTITIES = {
  damage: {name: 'damage of joints', unit: '', factor: 1},
  opening: {name: 'opening of joints', unit: 'mm', factor: 1e3},
  slip: {name: 'slip of joints', unit: 'mm', factor: 1e3},
  stress: {name: 'smallest principal stress', unit: 'MPa', factor: 1e-6},
  displacement: {name: 'displacement', unit: 'mm', factor: 1e3}
};
const SHAPE = {name: 'displacement, scaled', unit: '', factor: 1};  // for motions that are not of a run
const byId = id => document.getElementById(id);

function element(parent, tag, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  parent.appendChild(made);
  return made;
}

function mark(parent, tag, attributes = {}, text = null) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const key of Object.keys(attributes)) made.setAttribute(key, attributes[key]);
  if (text !== null) made.textContent = text;
  parent.appendChild(made);
  return made;
}

function drawing(parent) {
  return mark(parent, 'svg', {'font-family': 'sans-serif', 'font-size': 12, fill: '#222', xmlns: 'http://www.w3.org/2000/svg'});
}

// A number with three significant digits.
function short(value, digits = 3) {
  if (value === null || value === undefined || !isFinite(value)) return '\u2013';
  const size = Math.abs(value);
  if (size >= 1e5 || (size > 0 && size < 1e-3)) return value.toExponential(digits - 1);
  const rounded = Number(value.toPrecision(digits));
  return String(size >= 10 ** digits ? Math.round(value) : rounded);
}

// Largest of 1, 2 or 5 times a power of ten that is not above x.
function roundDown(x) {
  const power = 10 ** Math.floor(Math.log10(x) + 1e-9);
  return [5, 2, 1].find(d => d * power <= x * (1 + 1e-9)) * power;
}

// Round numbers along an axis, about `most` of them.
function ticksOf(low, high, most) {
  const least = (high - low) / most, power = 10 ** Math.floor(Math.log10(least) + 1e-9);
  const step = [1, 2, 5, 10].map(d => d * power).find(s => s >= least * (1 - 1e-9));
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push(Number((k * step).toPrecision(12)));
  return ticks;
}

// Numbers along an axis without overlap of their texts. room: length of the axis, pixels.
function ticksThatFit(low, high, most, room) {
  for (let n = most; n > 1; --n) {
    const ticks = ticksOf(low, high, n), widest = Math.max(...ticks.map(t => widthOf(short(t)))) + 8;
    if (widest * ticks.length < room) return ticks;
  }
  return ticksOf(low, high, 1).slice(0, 2);
}

// Label, shortened by its "of ..." if there is not enough room.
const fitted = (label, room) => widthOf(label) <= room ? label : label.replace(/ of [^[]+\[/, ' [');

// Upper estimate of the width of a text of 12 pixels.
const widthOf = text => 7.4 * text.length;

// Colour of a value from -1 to 1, as red, green, blue in 0..1. 0 has the middle colour, negative values are cold.
function colourAt(t, {cold, middle, warm}) {
  const to = t < 0 ? cold : warm;
  return middle.map((c, k) => (c + Math.min(1, Math.abs(t)) * (to[k] - c)) / 255);
}
const cssOf = rgb => `rgb(${rgb.map(c => Math.round(255 * c))})`;
