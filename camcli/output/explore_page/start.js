"use strict";
/* ---- what the page stands on: its elements, its data, and whether it may move ---- */

const $ = id => document.getElementById(id);
const data = decoded(JSON.parse($("data").textContent));
const still = matchMedia("(prefers-reduced-motion: reduce)");
