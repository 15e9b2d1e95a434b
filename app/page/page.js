// Puts the page together and makes it move; window.ceilmap is for tests and for power users.

const storage = {
  read(key) { try { return localStorage.getItem(key); } catch { return null; } },
  write(key, value) { try { localStorage.setItem(key, value); } catch { /* kept for now alone */ } },
};

class Page {
  constructor() {
    this.map = new MapView(byId('map'), (stamp) => this.pick(stamp));
    this.charts = new Charts(byId('charts'), (stamp) => this.pick(stamp));
    this.readout = new Readout(byId('readout'));
    this.layers = new LayerPanel(byId('layers'), (key, shown) => {
      this.map.toggle(key, shown);
      this.map.setTime(this.player.time);
    }, (key, opacity) => this.map.setMosaicOpacity(opacity));
    this.player = new Player((time) => this.showTime(time));
    this.model = null;
    this.tables = '';
  }

  pick(stamp) {
    this.player.play(false);
    this.player.go(stamp);
  }

  showTime(time) {
    this.map.setTime(time);
    this.charts.setTime(time);
    this.readout.setTime(time);
  }

  /** Takes over a document: all of it, or that nothing but the state is new. */
  update(json) {
    this.showBanner('');
    if (json.unchanged) {
      if (this.model) this.model.state = json.state;
    } else {
      this.show(readDocument(json));
    }
    this.showState(json.state);
  }

  show(model) {
    this.model = model;
    document.title = model.title;
    byId('title').textContent = model.title;
    byId('note').textContent = model.note;
    this.map.show(model);
    this.layers.show(this.map.list());
    this.charts.show(model);
    this.readout.show(model);
    const tables = JSON.stringify(model.tables);
    if (tables !== this.tables) showTables(byId('tables'), model);
    this.tables = tables;
    byId('player').hidden = model.lastStamp <= model.firstStamp;
    this.player.show(model);
  }

  showState(state) {
    const element = byId('run-state');
    element.hidden = !this.served;
    element.textContent = progressText(state);
    element.classList.toggle('running', state.running);
    if (this.served && !state.running) this.showBanner('The run has ended.');
  }

  showBanner(text) {
    const banner = byId('banner');
    banner.hidden = !text;
    if (banner.textContent !== text) banner.textContent = text;
  }

  /** Draws everything again, in the colours of the theme. */
  recolour() {
    if (!this.model) return;
    this.map.show(this.model);
    this.layers.show(this.map.list());
    this.charts.recolour();
    this.readout.show(this.model);
    showTables(byId('tables'), this.model);
    this.showTime(this.player.time);
  }

  follow(url) {
    this.served = true;
    new Poller(url, () => this.model.state.revision, (json) => this.update(json), () => this.onNoAnswer());
  }

  onNoAnswer() {
    const ended = this.model && !this.model.state.running;
    this.showBanner(ended ? 'The run has ended.' : 'No answer: the program has ended or cannot be reached.');
  }

  state() {
    if (!this.model) return null;  // a served page that waits for the first answer
    return {
      time: this.player.time,
      first: this.player.first,
      last: this.player.last,
      playing: this.player.playing,
      following: this.player.atEnd(),
      robots: this.map.robots.map((robot) => ({
        name: robot.path.name, x: robot.pose.x, y: robot.pose.y, yaw: robot.pose.yaw,
        shown: robot.visible, status: robot.pose.status, pixel: robot.pixel(),
      })),
      layers: Object.fromEntries(this.map.list().map(({key, shown}) => [key, shown])),
      opacity: this.map.mosaicOpacity,
      view: this.map.view(),
      charts: this.charts.charts.map((chart) => chart.range()),
      revision: this.model.state.revision,
      running: this.model.state.running,
    };
  }
}

const page = new Page();

/** @param theme  'light' or 'dark'. */
function applyTheme(theme) {
  document.documentElement.dataset.theme = theme;
  page.recolour();
}

const darkPreferred = matchMedia('(prefers-color-scheme: dark)');
const wantedTheme = () => storage.read('ceilmap-theme') ?? (darkPreferred.matches ? 'dark' : 'light');
applyTheme(wantedTheme());
darkPreferred.addEventListener('change', () => applyTheme(wantedTheme()));
byId('theme').addEventListener('click', () => {
  const theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  storage.write('ceilmap-theme', theme);
  applyTheme(theme);
});
// Paper is white.
let themeOfScreen = null;
addEventListener('beforeprint', () => {
  themeOfScreen = document.documentElement.dataset.theme;
  if (themeOfScreen === 'dark') applyTheme('light');
});
addEventListener('afterprint', () => { if (themeOfScreen === 'dark') applyTheme('dark'); });

if (matchMedia('(max-width: 60rem)').matches) byId('layer-panel').open = false;

window.ceilmap = {
  /** Moves the slider to the pose of a stamp (s). */
  setTime(stamp) { page.pick(stamp); },
  /** Shows another document (docs: app/page/README.md). */
  update(json) { page.update(json); },
  state() { return page.state(); },
  /** Height of the ceiling above the floor at a place (m); null where it is not known. */
  heightAt(x, y) {
    const height = page.model && page.model.heights ? page.model.heights.at(x, y) : NaN;
    return Number.isFinite(height) ? height : null;
  },
  /** Pixel of the map's rectangle where a place (in the page's unit) is drawn. */
  pixelOf(x, y) { return page.map.pixelOf(x, y); },
};

const given = JSON.parse(byId('document').textContent);
if (given.document_url) {
  byId('title').textContent = given.title;
  page.follow(given.document_url);
} else {
  page.update(given);
}
