// Light and dark: the page's by its style sheet, the picture's here.

const COLORS = {
  light: { background: "#f4f6f8", grid: "#7b8794" },
  dark: { background: "#15191e", grid: "#8d99a6" },
};

export class Theme {
  constructor(view, plots) {
    this.view = view;
    this.plots = plots;
    this.set(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  }

  set(name) {
    this.name = name;
    document.documentElement.dataset.theme = name;
    this.view.paint(COLORS[name]);
    this.plots.layout();
  }

  toggle() {
    this.set(this.name === "dark" ? "light" : "dark");
  }
}
