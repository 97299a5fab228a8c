// The viewer's looks: readable from the last row, light, and nothing that leaks into the page around it.
export const STYLE = `
.hl { --ink:#1F2933; --faint:#5b6773; --rule:#D5DBE1; --wash:#f4f6f8; --blue:#0072B2; --vermilion:#D55E00;
  position:relative; display:grid; grid-template-columns:minmax(270px,21%) minmax(320px,1fr) minmax(280px,21%); grid-template-rows:minmax(0,1fr) auto auto;
  width:100%; height:100%; min-height:480px; box-sizing:border-box; overflow:hidden; background:#fff; color:var(--ink);
  font:15px/1.35 system-ui,-apple-system,"Segoe UI","Noto Sans",sans-serif; text-align:left; }
.hl *, .hl *::before { box-sizing:border-box; }
.hl[data-size=narrow] { grid-template-columns:minmax(0,1fr) 290px; grid-template-rows:minmax(0,1fr) auto auto; }
.hl[data-size=tiny] { grid-template-columns:minmax(0,1fr); grid-template-rows:340px auto auto minmax(0,1fr); }
.hl button, .hl input, .hl select { font:inherit; color:inherit; margin:0; }
.hl :focus-visible { outline:3px solid #56B4E9; outline-offset:1px; }
.hl-stage { position:relative; grid-column:2; grid-row:1; min-height:0; overflow:hidden; background:linear-gradient(#e3e8ed,#fff); }
.hl-stage canvas { position:absolute; inset:0; width:100%; height:100%; display:block; cursor:grab; touch-action:none; }
.hl-stage canvas:active { cursor:grabbing; }
.hl-stage canvas:focus-visible { outline-offset:-3px; }
.hl-tag { position:absolute; z-index:3; pointer-events:none; background:#1f2933; color:#fff; padding:4px 10px; border-radius:6px; max-width:320px; font-size:15px; }
.hl-tag small { display:block; color:#d5dbe1; font-size:13px; font-style:italic; }
.hl-bar { position:absolute; z-index:2; left:10px; right:10px; display:flex; flex-wrap:wrap; gap:6px; pointer-events:none; } .hl-bar > * { pointer-events:auto; }
.hl-bar.top { top:10px; } .hl-bar.top .gap { flex:1; } .hl-bar.bottom { bottom:10px; justify-content:flex-end; }
.hl-seg { display:inline-flex; border:1px solid #b9c2cb; border-radius:8px; overflow:hidden; background:rgba(255,255,255,.92); }
.hl-seg button, .hl-btn { border:0; background:transparent; padding:5px 10px; cursor:pointer; white-space:nowrap; border-radius:0; }
.hl-seg button + button { border-left:1px solid var(--rule); }
.hl .hl-btn { border:1px solid #b9c2cb; border-radius:8px; background:rgba(255,255,255,.92); }
.hl-seg button:hover, .hl .hl-btn:hover { background:#e8f1f8; }
.hl .hl-seg button[aria-pressed=true], .hl .hl-btn[aria-pressed=true] { background:var(--blue); color:#fff; }
.hl .hl-btn.rec[aria-pressed=true] { background:var(--vermilion); }
.hl-bar .gap { flex:1; } .hl .hl-seg button.due { opacity:.55; }
.hl button:disabled { opacity:.45; cursor:default; }
.hl-menu { position:relative; } .hl-menu > div { position:absolute; right:0; bottom:calc(100% + 4px); z-index:6; background:#fff; border:1px solid #b9c2cb; border-radius:8px; padding:4px; box-shadow:0 6px 20px rgba(31,41,51,.18); width:max-content; max-width:280px; }
.hl-menu > div[hidden] { display:none; } .hl-menu > div button { display:block; width:100%; text-align:left; border:0; background:none; padding:6px 10px; border-radius:6px; cursor:pointer; }
.hl-menu > div button:hover, .hl-menu > div button:focus-visible { background:#e8f1f8; }
.hl-clips { grid-column:2; grid-row:2; border-top:1px solid var(--rule); padding:8px 12px 6px; background:#fff; min-width:0; }
.hl-chips { display:flex; flex-wrap:wrap; gap:4px; margin-bottom:6px; max-height:104px; overflow:auto; }
.hl-chips button { border:1px solid #b9c2cb; background:#fff; border-radius:14px; padding:2px 9px; font-size:14px; cursor:pointer; }
.hl-chips button:hover { background:#e8f1f8; } .hl-chips button[aria-pressed=true] { background:var(--blue); border-color:var(--blue); color:#fff; }
.hl-play { display:flex; align-items:center; gap:10px; }
.hl-play .go { width:44px; height:34px; border-radius:17px; border:0; background:var(--blue); color:#fff; cursor:pointer; flex:none; display:grid; place-items:center; }
.hl-play .go svg { width:16px; height:16px; fill:currentColor; }
.hl-play input[type=range] { flex:1; min-width:60px; }
.hl-play output { font-variant-numeric:tabular-nums; min-width:92px; text-align:right; }
.hl-curves { grid-column:2; grid-row:3; display:grid; grid-template:minmax(0,1fr) / 1fr 1fr; height:190px; border-top:1px solid var(--rule); min-width:0; }
.hl-curves > div { position:relative; min-width:0; min-height:0; overflow:hidden; } .hl-curves > div + div { border-left:1px solid var(--rule); }
.hl-curves canvas { position:absolute; inset:0; width:100%; height:100%; display:block; }
.hl-curves i { position:absolute; left:0; top:0; width:2px; margin-left:-1px; background:var(--ink); will-change:transform; } .hl-curves i[hidden] { display:none; }
.hl-side { contain:strict; grid-row:1 / span 3; display:flex; flex-direction:column; height:0; min-height:100%; min-width:0; background:#fff; }
.hl-side.m { grid-column:1; border-right:1px solid var(--rule); } .hl-side.j { grid-column:3; border-left:1px solid var(--rule); }
.hl-side header { padding:9px 12px 7px; border-bottom:1px solid var(--rule); }
.hl-side h2 { margin:0; padding:0; font-size:17px; font-weight:650; line-height:1.3; border:0; color:var(--ink); display:flex; justify-content:space-between; align-items:baseline; }
.hl-side h2 small { font-weight:400; font-size:13px; color:var(--faint); }
.hl-side input[type=search] { width:100%; margin-top:6px; padding:5px 10px; border:1px solid #b9c2cb; border-radius:8px; background:#fff; }
.hl-list { flex:1; overflow:auto; padding:2px 0 10px; min-height:0; scrollbar-width:thin; }
.hl-list h3 { position:sticky; top:-2px; z-index:1; margin:0; padding:7px 12px 3px; font-size:14px; font-weight:650; background:#fff; color:var(--ink); display:flex; align-items:center; gap:7px; line-height:1.3; }
.hl-list h3 i { width:11px; height:11px; border-radius:3px; flex:none; }
.hl-row { display:grid; grid-template-columns:62px 1fr 46px; align-items:center; gap:8px; padding:1px 12px; min-height:27px; border-left:4px solid transparent; }
.hl-row.j { grid-template-columns:26px 122px 1fr 46px; gap:5px; padding-left:6px; }
.hl-row:hover, .hl-row:focus-within { background:var(--wash); }
.hl-row.on { border-left-color:var(--tint); background:#fbf7ef; }
.hl-row .who { border:0; background:none; padding:2px 0; text-align:left; font-weight:600; cursor:pointer; white-space:nowrap; overflow:hidden; text-overflow:ellipsis; }
.hl-row.j .who { font-weight:400; } .hl-row .who[aria-pressed=true] { text-decoration:underline; text-decoration-thickness:3px; text-underline-offset:3px; text-decoration-color:var(--tint,var(--blue)); }
.hl-row output { text-align:right; font-variant-numeric:tabular-nums; white-space:nowrap; }
.hl-row.follows { color:var(--faint); }
.hl-row.linked .who { color:var(--vermilion); font-weight:700; }
.hl-row[hidden], .hl-list section[hidden] { display:none; }
.hl input[type=range] { -webkit-appearance:none; appearance:none; width:100%; height:22px; margin:0; cursor:pointer; background:transparent; --track:linear-gradient(to right,var(--tint,var(--blue)) var(--p,0%),#dde3e9 var(--p,0%)); }
.hl input[type=range]::-webkit-slider-runnable-track { height:6px; border-radius:3px; background:var(--track); }
.hl input[type=range]::-moz-range-track { height:6px; border-radius:3px; background:var(--track); }
.hl input[type=range]::-webkit-slider-thumb { -webkit-appearance:none; width:16px; height:16px; margin-top:-5px; border-radius:8px; border:2px solid #fff; background:var(--tint,var(--blue)); box-shadow:0 0 0 1px rgba(31,41,51,.35); }
.hl input[type=range]::-moz-range-thumb { width:12px; height:12px; border-radius:8px; border:2px solid #fff; background:var(--tint,var(--blue)); box-shadow:0 0 0 1px rgba(31,41,51,.35); }
.hl input[type=range]:disabled { cursor:default; opacity:.5; }
.hl input[aria-disabled=true] { pointer-events:none; }
.hl .hl-lock { border:0; background:none; padding:2px 0; cursor:pointer; color:#8a96a3; display:grid; place-items:center; width:26px; height:24px; border-radius:6px; }
.hl-lock:hover { background:#e8f1f8; } .hl-lock svg { width:16px; height:16px; fill:currentColor; } .hl .hl-lock[aria-pressed=true] { color:#fff; background:var(--vermilion); }
.hl-lock .shut { display:none; } .hl-lock[aria-pressed=true] .shut { display:block; } .hl-lock[aria-pressed=true] .open { display:none; }
.hl-range { position:relative; height:12px; border-radius:6px; background:#e9edf1; overflow:hidden; }
.hl-range b { position:absolute; top:0; bottom:0; left:0; width:100%; transform-origin:0 50%; background:#8fc3e6; }
.hl-range i { position:absolute; top:0; bottom:0; width:2px; background:#5b6773; }
.hl-more { border-top:1px solid var(--rule); padding:8px 12px; height:206px; overflow:auto; flex:none; font-size:14px; background:var(--wash); }
.hl-more strong { display:block; font-size:15px; } .hl-more .faint, .hl-none { color:var(--faint); } .hl-none { padding:12px; }
.hl-say { position:absolute; z-index:5; left:50%; bottom:56px; transform:translateX(-50%); max-width:86%; padding:8px 14px; border-radius:8px; background:#1f2933; color:#fff; font-size:15px; box-shadow:0 4px 18px rgba(31,41,51,.3); }
.hl-say.bad { background:#a33a00; } .hl-say[hidden] { display:none; }
.hl-tabs { display:none; }
.hl[data-size=narrow] .hl-stage, .hl[data-size=narrow] .hl-clips, .hl[data-size=narrow] .hl-curves { grid-column:1; }
.hl[data-size=narrow] .hl-side { grid-column:2; grid-row:1 / span 3; border-left:1px solid var(--rule); border-right:0; padding-top:40px; }
.hl[data-size=narrow] .hl-tabs { display:flex; grid-column:2; grid-row:1; align-self:start; z-index:2; padding:6px 10px 0; }
.hl[data-size=tiny] .hl-stage, .hl[data-size=tiny] .hl-clips, .hl[data-size=tiny] .hl-curves, .hl[data-size=tiny] .hl-side, .hl[data-size=tiny] .hl-tabs { grid-column:1; }
.hl[data-size=tiny] .hl-curves { display:none; } .hl[data-size=tiny] .hl-tabs { display:flex; grid-row:3; padding:6px 10px 0; } .hl[data-size=tiny] .hl-side { grid-row:4; border:0; }
.hl[data-size=narrow][data-tab=muscles] .hl-side.j, .hl[data-size=narrow][data-tab=joints] .hl-side.m,
.hl[data-size=tiny][data-tab=muscles] .hl-side.j, .hl[data-size=tiny][data-tab=joints] .hl-side.m { display:none; }
.hl.low .hl-curves { height:128px; } .hl.low .hl-chips { flex-wrap:nowrap; overflow:auto hidden; padding-bottom:2px; scrollbar-width:thin; } .hl.low .hl-chips button { flex:none; } .hl.low .hl-more { height:120px; } .hl[data-panels=none] { grid-template:minmax(0,1fr) / minmax(0,1fr); min-height:0; }
.hl[data-panels=none] :is(.hl-side,.hl-tabs,.hl-clips,.hl-curves,.hl-bar.bottom) { display:none; }
.hl[data-panels=none] .hl-stage { grid-column:1; grid-row:1; }
.hl-wait { position:absolute; inset:0; display:grid; place-items:center; color:var(--faint); font-size:18px; }
`;
