// Style of the viewer. It takes the colours of the page where it has ours (see base.css), and brings its own elsewhere.

export const STYLE = `
.cv { --cv-card: var(--card, #fff); --cv-ink: var(--ink, #1c1f23); --cv-faint: var(--faint, #646b75);
  --cv-line: var(--line, #e2e5e9); --cv-hover: var(--hover, #f1f4f8); --cv-accent: var(--accent, #1f6feb);
  display: grid; grid-template-columns: minmax(0, 1fr) 300px; width: 100%; height: 100%; min-height: 320px;
  border: 1px solid var(--cv-line); border-radius: 12px; overflow: hidden; background: var(--cv-card); color: var(--cv-ink);
  font: 14px/1.4 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; box-sizing: border-box; text-align: left; }
.cv *, .cv *::before { box-sizing: border-box; }
.cv [hidden] { display: none !important; }
.cv.cv-bare { grid-template-columns: minmax(0, 1fr); }
.cv-view { position: relative; overflow: hidden; min-height: 240px;
  background: radial-gradient(120% 90% at 50% 30%, #fdfdfc 0%, #eef0f2 55%, #d9dee3 100%); }
@media (prefers-color-scheme: dark) { :root:not([data-theme="light"]) .cv { --cv-card: var(--card, #1a1e24); --cv-ink: var(--ink, #e7eaee);
  --cv-faint: var(--faint, #98a1ad); --cv-line: var(--line, #2c323a); --cv-hover: var(--hover, #222831); --cv-accent: var(--accent, #6ea8ff);
  color-scheme: dark; } }
@media (prefers-color-scheme: dark) { :root:not([data-theme="light"]) .cv-view {
  background: radial-gradient(120% 90% at 50% 30%, #3a4149 0%, #262b31 55%, #171a1f 100%); } }
:root[data-theme="dark"] .cv-view { background: radial-gradient(120% 90% at 50% 30%, #3a4149 0%, #262b31 55%, #171a1f 100%); }
.cv canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; outline: none; }
.cv canvas.cv-hot { cursor: pointer; }
.cv canvas:active { cursor: grabbing; }
.cv canvas:focus-visible { box-shadow: inset 0 0 0 3px var(--cv-accent); }
.cv-words { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.cv-label { position: absolute; left: 0; top: 0; padding: 1px 7px; border-radius: 999px; white-space: nowrap;
  font-size: 12px; background: rgb(20 24 30 / .82); color: #fff; }
.cv-label-hint { background: #1457b8; }
.cv-tip { position: absolute; left: 12px; bottom: 12px; max-width: calc(100% - 24px); padding: 3px 10px; border-radius: 8px;
  font-size: 12.5px; background: rgb(20 24 30 / .82); color: #fff; pointer-events: none; }
.cv-tools { position: absolute; right: 10px; top: 10px; display: flex; gap: 6px; }
.cv-tools button { width: 36px; height: 36px; padding: 0; border-radius: 10px; border: 1px solid var(--cv-line);
  background: var(--cv-card); color: var(--cv-ink); font-size: 17px; line-height: 1; }
.cv-panel { border-left: 1px solid var(--cv-line); padding: 12px 14px; overflow-y: auto; overscroll-behavior: contain; min-height: 0; }
.cv-group { margin-bottom: 14px; }
.cv-title { display: block; font-size: 12px; font-weight: 600; color: var(--cv-faint); margin-bottom: 5px; }
.cv-row { display: flex; flex-wrap: wrap; gap: 6px; }
.cv button { cursor: pointer; font: inherit; }
.cv-button, .cv-select, .cv-search { font: inherit; border: 1px solid var(--cv-line); border-radius: 8px; padding: 5px 12px; min-height: 34px;
  background: var(--cv-card); color: var(--cv-ink); }
.cv-select, .cv-search { width: 100%; }
.cv-search { margin-bottom: 6px; }
.cv-button:hover, .cv-toggle:hover, .cv-tools button:hover { background: var(--cv-hover); }
.cv-check { display: inline-flex; align-items: center; gap: 5px; padding: 4px 10px 4px 0; min-height: 28px; }
.cv :focus-visible { outline: 2px solid var(--cv-accent); outline-offset: 1px; }
.cv-owner > summary { cursor: pointer; padding: 5px 0; font-weight: 600; }
.cv-joint { display: grid; grid-template-columns: minmax(0, 1fr) auto; gap: 1px 8px; align-items: center; padding: 4px 6px; margin: 0 -6px; border-radius: 8px; }
.cv-joint label { overflow-wrap: anywhere; }
.cv-joint output { color: var(--cv-faint); font-variant-numeric: tabular-nums; font-size: 13px; text-align: right; }
.cv-joint input { width: 100%; margin: 0; min-height: 24px; accent-color: var(--cv-accent); }
.cv-toggle { border: 1px solid var(--cv-line); border-radius: 7px; padding: 2px 9px; font-size: 13px; min-width: 58px; min-height: 26px;
  background: var(--cv-card); color: var(--cv-ink); }
.cv-chosen { background: var(--cv-hover); }
.cv-help { color: var(--cv-faint); font-size: 12px; }
.cv-said { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); }
@media (max-width: 760px) { .cv { grid-template-columns: minmax(0, 1fr); grid-template-rows: minmax(260px, 58%) minmax(0, 1fr); }
  .cv.cv-bare { grid-template-rows: minmax(0, 1fr); }
  .cv-panel { border-left: 0; border-top: 1px solid var(--cv-line); } .cv-joint input { min-height: 32px; } .cv-button { min-height: 40px; } }
`;

export function addStyle() {
  if (document.getElementById("cv-style")) return;
  const style = document.createElement("style");
  style.id = "cv-style";
  style.textContent = STYLE;
  document.head.append(style);
}
