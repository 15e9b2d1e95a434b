// The map: picture, layers, robots.

/** The robot at a pose: an arrow of fixed size, and on the floor what its camera sees. */
class Robot {
  constructor(path, colour, map, renderer) {
    this.path = path;
    this.arrow = makeSvg('path', {d: 'M12 0 L-9 8.5 L-4.5 0 L-9 -8.5 Z', fill: colour,
                                  stroke: themeColour('--halo'), 'stroke-width': 1.5,
                                  'stroke-linejoin': 'round'});
    const icon = makeSvg('svg', {width: 32, height: 32, viewBox: '-16 -16 32 32',
                                 'aria-hidden': 'true'}, this.arrow);
    this.marker = L.marker([0, 0], {
      interactive: false, keyboard: false, pane: 'robots',
      zIndexOffset: path.role === 'truth' ? -100000 : 0,  // below the others
      icon: L.divIcon({html: icon, className: 'robot', iconSize: [32, 32], iconAnchor: [16, 16]}),
    });
    const shape = {interactive: false, renderer, color: colour, weight: 1.5, smoothFactor: 0};
    this.footprint = L.polygon([], {...shape, fillOpacity: 0.1});
    this.ellipse = L.polygon([], {...shape, fillOpacity: 0.25, weight: 1});
    this.map = map;
    this.pose = null;
  }

  moveTo(pose, visible, withView) {
    this.pose = pose;
    this.visible = visible && pose.shown;
    const {index, shown} = pose;
    this.place(this.footprint, this.visible && withView);
    this.place(this.ellipse, this.visible);
    this.place(this.marker, visible && index >= 0);
    if (index < 0) return;
    this.marker.setLatLng(latLng(pose.x, pose.y));
    this.marker.setOpacity(shown ? 1 : 0.35);
    this.arrow.setAttribute('transform', `rotate(${-pose.yaw * 180 / Math.PI})`);
    this.footprint.setLatLngs(this.path.footprint.length
      ? toLatLngs(this.path.footprintAt(index)) : []);
    this.ellipse.setLatLngs(this.path.knowsSigma(index)
      ? toLatLngs(this.path.ellipseAt(index)) : []);
  }

  place(layer, wanted) {
    if (wanted) layer.addTo(this.map);
    else layer.remove();
  }

  remove() {
    for (const layer of [this.marker, this.footprint, this.ellipse]) layer.remove();
  }

  /** Where the arrow is on the map's rectangle, in pixels, as the browser has drawn it. */
  pixel() {
    const icon = this.marker.getElement();
    if (!icon || !icon.isConnected) return null;
    const box = icon.getBoundingClientRect();
    const frame = this.map.getContainer().getBoundingClientRect();
    return [(box.left + box.right) / 2 - frame.left, (box.top + box.bottom) / 2 - frame.top];
  }
}

/** A bar of 1, 2 or 5 times a power of ten of the page's unit. */
const ScaleBar = L.Control.extend({
  options: {position: 'bottomleft', unit: 'm'},
  onAdd(map) {
    this.bar = make('div', {class: 'scale-bar'});
    map.on('zoomend moveend resize', this.update, this);
    return this.bar;
  },
  onRemove(map) { map.off('zoomend moveend resize', this.update, this); },
  update() {
    const scale = this._map.options.crs.scale(this._map.getZoom());
    const longest = 140 / scale;
    const power = 10 ** Math.floor(Math.log10(longest));
    const length = [5, 2, 1].find((factor) => factor * power <= longest) * power;
    this.bar.style.width = `${length * scale}px`;
    this.bar.textContent = `${Number(length.toPrecision(1))} ${this.options.unit}`;
  },
});

/** Where the pointer is, and the height of the ceiling there. */
const PointerText = L.Control.extend({
  options: {position: 'bottomright'},
  onAdd(map) {
    this.text = make('div', {class: 'pointer', hidden: true});
    map.on('mousemove', this.update, this);
    map.on('mouseout', this.hide, this);
    return this.text;
  },
  onRemove(map) {
    map.off('mousemove', this.update, this);
    map.off('mouseout', this.hide, this);
  },
  update({latlng}) {
    if (!this.options.model) return;
    const {unit, heights} = this.options.model;
    const digits = unit === 'm' ? 2 : 0;
    const height = heights ? heights.at(latlng.lng, latlng.lat) : NaN;
    const texts = [`x ${decimals(latlng.lng, digits)}`, `y ${decimals(latlng.lat, digits)} ${unit}`];
    if (Number.isFinite(height)) texts.push(`height ${decimals(height, 2)} m`);
    else if (heights) texts.push('height not known');
    this.text.textContent = texts.join(' \u00b7 ');
    this.text.hidden = false;
  },
  hide() { this.text.hidden = true; },
});

/** How the ceiling looked before, left of a divider that the user moves. */
class BeforePicture {
  constructor(map) {
    this.map = map;
    this.pane = map.createPane('before');
    this.pane.style.zIndex = 210;
    this.pane.style.pointerEvents = 'none';
    this.slider = make('input', {type: 'range', class: 'divider', min: 0, max: 1, step: 0.001, value: 0.5,
                                 'aria-label': 'Divider: before on the left, after on the right'});
    this.line = make('div', {class: 'divider-line'}, make('span', {}, 'before'), make('span', {}, 'after'));
    this.slider.addEventListener('input', () => this.clip());
    L.DomEvent.disableClickPropagation(this.slider);
    map.on('move zoom zoomend resize', () => this.clip());
  }

  show(picture) {
    if (this.overlay) this.overlay.remove();
    for (const part of [this.line, this.slider]) part.remove();
    this.overlay = null;
    if (!picture) return;
    this.overlay = new PlacedImage(picture.url, picture.corners,
                                   {className: 'mosaic', pane: 'before', alt: 'Mosaic, before'}).addTo(this.map);
    this.map.getContainer().append(this.line, this.slider);
    this.clip();
  }

  /** Panes are as large as nothing: their clip is in pixels of the map's layers. */
  clip() {
    if (!this.overlay) return;
    const {x: width, y: height} = this.map.getSize();
    const at = Number(this.slider.value) * width;
    this.line.style.left = `${at}px`;
    const [from, to] = [[0, 0], [at, height]].map((point) => this.map.containerPointToLayerPoint(point));
    this.pane.style.clip = `rect(${from.y}px, ${to.x}px, ${to.y}px, ${from.x}px)`;
  }
}

class MapView {
  /** @param onPick  called with the stamp of the pose that was clicked at. */
  constructor(container, onPick) {
    this.map = L.map(container, {
      crs: L.CRS.Simple, preferCanvas: true, attributionControl: false, zoomControl: false,
      zoomSnap: 0, zoomDelta: 0.75, wheelPxPerZoomLevel: 90, minZoom: -14, maxZoom: 14,
      fadeAnimation: false, maxBoundsViscosity: 0,
    });
    this.map.setView([0, 0], 4);
    this.panes = {};
    for (const [name, level] of [['plan', 150], ['halo', 370], ['bands', 380], ['truth', 390], ['lines', 400], ['marks', 420]]) {
      this.map.createPane(name).style.zIndex = level;
      this.panes[name] = L.canvas({pane: name, padding: 0.3});
    }
    this.map.createPane('robots').style.zIndex = 620;
    this.map.createPane('floor').style.zIndex = 440;
    this.floor = L.svg({pane: 'floor'});
    this.map.createPane('heights').style.zIndex = 250;
    for (const pane of ['floor', 'robots', 'heights']) this.map.getPane(pane).style.pointerEvents = 'none';
    this.before = new BeforePicture(this.map);
    this.addControls();
    this.chosen = new Map();  // what the user has switched: key -> shown
    this.layers = [];
    this.robots = [];
    this.picture = this.pictureUrl = null;
    this.mosaicOpacity = 0.7;
    this.map.on('zoomend', () => this.sharpen());
    this.viewIsUsers = false;
    this.map.on('click', ({containerPoint}) => {
      const stamp = this.stampNear(containerPoint);
      if (stamp !== null) onPick(stamp);
    });
    for (const type of ['wheel', 'pointerdown', 'dblclick', 'keydown']) {
      container.addEventListener(type, (event) => {
        if (!event.target.closest('.fit')) this.viewIsUsers = true;
      }, {capture: true, passive: true});
    }
    new ResizeObserver(() => this.resize()).observe(container);
  }

  addControls() {
    L.control.zoom({position: 'topleft'}).addTo(this.map);
    const Fit = L.Control.extend({
      onAdd: () => {
        const button = make('a', {class: 'fit', href: '#', role: 'button', title: 'Show all',
                                  'aria-label': 'Show all'},
          makeSvg('svg', {width: 14, height: 14, viewBox: '0 0 14 14', fill: 'none', stroke: 'currentColor',
                          'stroke-width': 1.6, 'aria-hidden': 'true'},
                  makeSvg('path', {d: 'M1 5V1H5M9 1H13V5M13 9V13H9M5 13H1V9'})));
        L.DomEvent.on(button, 'click', (event) => {
          L.DomEvent.stop(event);
          this.viewIsUsers = false;
          this.fit();
        });
        return make('div', {class: 'leaflet-bar'}, button);
      },
    });
    new Fit({position: 'topleft'}).addTo(this.map);
    this.scaleBar = new ScaleBar().addTo(this.map);
    this.pointer = new PointerText().addTo(this.map);
  }

  resize() {
    this.map.invalidateSize({animate: false});
    if (!this.viewIsUsers) this.fit();
  }

  /** Takes over what the page shows; the view and the choice of layers stay the user's. */
  show(model) {
    this.model = model;
    this.scaleBar.options.unit = model.unit;
    this.pointer.options.model = model;
    this.showPicture(model.picture);
    this.before.show(model.before);
    this.fadeMosaic();
    for (const layer of this.layers) this.switchLayer(layer, false);
    for (const robot of this.robots) robot.remove();
    this.layers = pageLayers(model, this.panes, this.map);
    for (const layer of this.layers) {
      this.switchLayer(layer, this.chosen.get(layer.key) ?? layer.shown);
    }
    this.robots = model.paths.filter((path) => path.role !== 'before').map((path) =>
      new Robot(path, colourOf(model, path.name), this.map, this.floor));
    if (!this.viewIsUsers) this.fit();
  }

  /**
   * The new picture takes the old one's place when it is there, not before: nothing flickers. It
   * is asked for once: who served it may be gone a moment later.
   */
  showPicture(picture) {
    const url = picture && picture.url;
    if (url === this.pictureUrl) return;
    this.pictureUrl = url;
    if (!picture) {
      this.replacePicture(null);
      return;
    }
    const {corners} = picture;
    const image = new Image();
    image.alt = 'Mosaic';
    image.onload = () => {
      if (this.pictureUrl !== url) return;  // a newer one has been asked for
      this.replacePicture(new PlacedImage(image, corners, {className: 'mosaic', pane: 'tilePane'}));
    };
    image.src = url;
  }

  replacePicture(overlay) {
    if (this.picture) this.picture.remove();
    this.picture = overlay;
    this.fadeMosaic();
    if (overlay && this.isChosen('mosaic')) overlay.addTo(this.map);
    this.sharpen();
  }

  /** Pixels with clear edges, once they are larger than those of the screen. */
  sharpen() {
    const image = this.picture && this.picture.getElement();
    if (!image || !image.naturalWidth) return;
    image.classList.toggle('enlarged', image.clientWidth > 1.5 * image.naturalWidth);
  }

  bounds() {
    const bounds = L.latLngBounds([]);
    const {picture, before, heights, paths, keyframes, spots} = this.model;
    const extend = (xs, ys) => {
      for (let i = 0; i < xs.length; ++i) if (!Number.isNaN(xs[i])) bounds.extend([ys[i], xs[i]]);
    };
    const pictures = [picture?.corners, before?.corners, heights?.placement.corners(heights.extent)];
    for (const corners of pictures.filter(Boolean)) bounds.extend(toLatLngs(allCorners(corners)));
    for (const path of paths) extend(path.x, path.y);
    extend(keyframes.x, keyframes.y);
    extend(spots.map((spot) => spot.x), spots.map((spot) => spot.y));
    return bounds;
  }

  fit() {
    if (!this.model) return;
    const bounds = this.bounds();
    if (bounds.isValid()) this.map.fitBounds(bounds, {padding: [24, 24], animate: false, maxZoom: 9});
  }

  setTime(time) {
    for (const robot of this.robots) {
      robot.moveTo(robot.path.poseAt(time), this.isShown(robot.path), this.isChosen('views'));
    }
  }

  isShown(path) { return this.layers.some((layer) => layer.path === path && layer.shown); }

  /** What the page lists: the picture first. */
  list() {
    const entry = (key, text, swatch) => ({key, text, swatch, shown: this.isChosen(key)});
    return [
      ...(this.model.picture ? [{...entry('mosaic', 'Mosaic', ['band', '#8a8f98']),
                                 opacity: this.model.plan ? this.mosaicOpacity : undefined}] : []),
      ...this.layers,
      ...(this.robots.some((robot) => robot.path.footprint.length)
        ? [entry('views', 'What the camera sees', ['frame', themeColour('--text')])] : []),
    ];
  }

  /** @param opacity  0 to 1, of the mosaic over a plan. */
  setMosaicOpacity(opacity) {
    this.mosaicOpacity = opacity;
    this.fadeMosaic();
  }

  fadeMosaic() {
    if (this.picture) this.picture.setOpacity(this.model?.plan ? this.mosaicOpacity : 1);
  }

  isChosen(key) { return this.chosen.get(key) ?? true; }

  toggle(key, shown) {
    this.chosen.set(key, shown);
    if (key === 'mosaic' && this.picture) {
      if (shown) this.picture.addTo(this.map);
      else this.picture.remove();
      this.sharpen();
    }
    for (const layer of this.layers) {
      if (layer.key === key) this.switchLayer(layer, shown);
    }
  }

  /** What nobody looks at is not even made. */
  switchLayer(layer, shown) {
    layer.shown = shown;
    if (shown) layer.group ??= layer.draw();
    if (shown) layer.group.addTo(this.map);
    else if (layer.group) layer.group.remove();
  }

  /** Stamp of the pose that is drawn nearest to a pixel, null if none is near. */
  stampNear(pixel) {
    const {lat: y, lng: x} = this.map.containerPointToLatLng(pixel);
    let nearest = 14 / this.map.options.crs.scale(this.map.getZoom());
    let stamp = null;
    for (const path of this.model.paths) {
      if (!this.isShown(path)) continue;
      for (let i = 0; i < path.length; ++i) {
        const distance = Math.hypot(path.x[i] - x, path.y[i] - y);
        if (distance < nearest) [nearest, stamp] = [distance, path.stamps[i]];
      }
    }
    return stamp;
  }

  pixelOf(x, y) {
    const {x: u, y: v} = this.map.latLngToContainerPoint(latLng(x, y));
    return [u, v];
  }

  view() {
    const {lat, lng} = this.map.getCenter();
    return {x: lng, y: lat, zoom: this.map.getZoom()};
  }
}
