// What each key does to the picture.
import { showUnfiltered } from "../compare/other_choice.js";
import { BEHIND, SHOWN_AS } from "./shader.js";
import { CURVES } from "./view_transform.js";

const PAN = 64; // pixels of the canvas

export function pictureKeys(view) {
  const { viewport, display, compare, probe } = view;
  const say = (text) => view.say(text);
  const zoom = (change) => () => { change(); say(`${Math.round(viewport.zoom * 100)} %`); };
  const step = (dx, dy) => () => {
    probe.step(dx, dy, viewport);
    if (view.source) say(probe.describe(probe.point, view.source.image, null, false));
  };
  const expose = (by) => () => { display.step("exposure", by); say(`${display.exposure} EV`); };
  const next = (name, values) => () => { display.next(name, values); say(String(display[name])); };
  const mode = (name) => () => { view.setCompare(compare.mode === name ? "off" : name); say(compare.mode === "off" ? "no comparison" : name); };
  return [
    { keys: ["ArrowLeft"], run: () => viewport.pan(PAN, 0) },
    { keys: ["ArrowRight"], run: () => viewport.pan(-PAN, 0) },
    { keys: ["ArrowUp"], run: () => viewport.pan(0, PAN) },
    { keys: ["ArrowDown"], shown: ["←", "→", "↑", "↓"], name: "move the picture", run: () => viewport.pan(0, -PAN) },
    { keys: ["+", "="], shown: ["+"], name: "zoom in", run: zoom(() => viewport.zoomBy(2)) },
    { keys: ["-"], name: "zoom out", run: zoom(() => viewport.zoomBy(0.5)) },
    { keys: ["f"], name: "fit the picture", run: zoom(() => viewport.fit()) },
    { keys: ["1"], name: "show at 1:1", run: zoom(() => viewport.zoomTo(1)) },
    { keys: ["l", "PageDown"], name: "next layer", run: () => view.stepLayer(1) },
    { keys: ["Shift+l", "PageUp"], shown: ["Shift+L", "PageUp"], name: "previous layer", run: () => view.stepLayer(-1) },
    { keys: ["e"], name: "brighter by a quarter stop", run: expose(0.25) },
    { keys: ["Shift+e"], shown: ["Shift+E"], name: "darker", run: expose(-0.25) },
    { keys: ["0"], name: "exposure, gamma and view as the job has them", run: () => { display.reset(); say(`${display.exposure} EV`); } },
    { keys: ["g"], name: "gamma up", run: () => { display.step("gamma", 0.1); say(`gamma ${display.gamma}`); } },
    { keys: ["Shift+g"], shown: ["Shift+G"], name: "gamma down", run: () => { display.step("gamma", -0.1); say(`gamma ${display.gamma}`); } },
    { keys: ["t"], name: "next view: linear, filmic, AgX", run: next("curve", CURVES) },
    { keys: ["m"], name: "next way to show: picture, false colours, signs, vectors", run: next("shownAs", Object.keys(SHOWN_AS)) },
    { keys: ["o"], name: "mark clipped pixels", run: () => { display.set("clipMarks", !display.clipMarks); say(display.clipMarks ? "marked" : "unmarked"); } },
    { keys: ["h"], name: "next background of transparent pixels: black, checkerboard, white, alpha", run: next("behind", Object.keys(BEHIND)) },
    { keys: ["d"], name: "dither", run: () => { display.set("dither", !display.dither); say(display.dither ? "dithered" : "not dithered"); } },
    { keys: ["w"], name: "wipe between two layers", run: mode("wipe") },
    { keys: ["x"], name: "difference of two layers", run: mode("difference") },
    { keys: ["q"], name: "onion: this frame and the one before, half of each", run: mode("onion") },
    { keys: ["i"], name: "map of structural similarity (SSIM)", run: mode("ssim") },
    { keys: ["y"], name: "map of visible differences (FLIP)", run: mode("flip") },
    { keys: ["b", " "], shown: ["B", "Space"], name: "show one picture, then the other", run: () => view.flip() },
    { keys: ["u"], name: "filtered or unfiltered (renders the job once more without filters)", run: () => showUnfiltered(view) },
    { keys: ["["], run: () => compare.set({ position: compare.position - 0.02 }) },
    { keys: ["]"], shown: ["[", "]"], name: "move the wipe", run: () => compare.set({ position: compare.position + 0.02 }) },
    { keys: ["r"], name: "turn the wipe by 15 degrees", run: () => compare.set({ angle: compare.angle + 15 }) },
    { keys: ["Shift+ArrowLeft"], run: step(-1, 0) },
    { keys: ["Shift+ArrowRight"], run: step(1, 0) },
    { keys: ["Shift+ArrowUp"], run: step(0, -1) },
    { keys: ["Shift+ArrowDown"], shown: ["Shift", "←", "→", "↑", "↓"], name: "select a pixel", run: step(0, 1) },
    { keys: ["Enter"], name: "pin the probe at it", run: () => probe.pin() },
    { keys: ["c"], name: "move the camera of a live job: arrows orbit, Shift and arrows pan, + and − move closer and away, F picks focus, Escape ends it", run: () => view.toggleCamera?.() },
    { keys: ["Shift+c"], shown: ["Shift+C"], name: "move objects of a live job: arrows move along the ground, Shift and arrows turn, raise and lower, N is the next object, Backspace puts it back, Escape ends it", run: () => view.toggleObjects?.() },
    { keys: ["?"], name: "show or hide this list", run: () => view.shortcuts.toggle() },
  ];
}
