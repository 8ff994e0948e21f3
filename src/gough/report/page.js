"use strict";
(() => {
  const charts = JSON.parse(document.getElementById("charts").textContent);
  // a chart stays on this computer: without these plotly.js offers to send it to a server of its makers
  const config = { displaylogo: false, responsive: true, scrollZoom: false, showSendToCloud: false, plotlyServerURL: "" };
  const buttons2d = [["toImage", "zoom2d", "pan2d", "resetScale2d"]];
  const buttons3d = [["toImage", "resetCameraDefault3d"]];

  function webgl() {
    try {
      return !!document.createElement("canvas").getContext("webgl");
    } catch (error) {
      return false;
    }
  }

  function values(entry) {
    const bytes = Uint8Array.from(atob(entry.bdata), (char) => char.charCodeAt(0));
    return Array.from(entry.dtype === "f4" ? new Float32Array(bytes.buffer) : new Float64Array(bytes.buffer));
  }

  // without WebGL the machine is seen from one side only: turned by 35 degrees about z, tilted by 20
  function flat(chart) {
    const [c, s, u, v] = [Math.cos(0.61), Math.sin(0.61), Math.cos(0.35), Math.sin(0.35)];
    const data = chart.data.map((trace) => {
      const [x, y, z] = [values(trace.x), values(trace.y), values(trace.z)];
      return {
        type: "scatter", mode: trace.mode, name: trace.name, hoverinfo: "name", marker: trace.marker,
        line: { color: trace.line.color, width: trace.line.width / 2 },
        x: x.map((_, i) => c * x[i] - s * y[i]),
        y: x.map((_, i) => v * (s * x[i] + c * y[i]) + u * z[i]),
      };
    });
    const axis = { visible: false };
    const layout = { ...chart.layout, xaxis: axis, yaxis: { ...axis, scaleanchor: "x" }, hovermode: "closest" };
    delete layout.scene;
    return { data, layout };
  }

  const drawn = new Set();
  function draw(box) {
    if (drawn.has(box.id)) return;
    drawn.add(box.id);
    let chart = charts[box.id];
    if (chart.layout.scene && !webgl()) chart = flat(chart);
    const scene = chart.layout.scene;
    if (scene && box.clientWidth < 850) { // its size goes by the height of the picture
      for (const n of "xyz") scene.aspectratio[n] *= box.clientWidth / 850;
    }
    const modeBarButtons = scene ? buttons3d : buttons2d;
    Plotly.newPlot(box, chart.data, chart.layout, { ...config, modeBarButtons });
  }

  // charts are drawn when they come near the window: the page is readable at once
  const boxes = [...document.querySelectorAll(".chart[id]")];
  const watch = new IntersectionObserver(
    (entries) => entries.filter((entry) => entry.isIntersecting).forEach((entry) => {
      watch.unobserve(entry.target);
      draw(entry.target);
    }),
    { rootMargin: "800px" },
  );
  boxes.forEach((box) => watch.observe(box));
  window.addEventListener("beforeprint", () => {
    boxes.forEach(draw);
    document.querySelectorAll("details").forEach((part) => { part.open = true; });
  });
})();
