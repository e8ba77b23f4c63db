// /metrics read as strictly as nobody else does: the text format 0.0.4 and the conventions of names, and no label
// that grows with what clients send. Functions for metrics.sh:
//   node metrics.mjs check FILE              the rules
//   node metrics.mjs same FILE FILE          no series that was not there before
//   node metrics.mjs grows FILE FILE         no counter went back
//   node metrics.mjs value FILE SERIES       its value
import { readFileSync } from 'node:fs';

const fail = (text) => { throw new Error(text); };
const number = (text) => /^[+-]?(\d+(\.\d+)?(e[+-]?\d+)?)$/.test(text) ? Number(text) : fail(`"${text}" is no number`);

function readSample(line, family) {
    const m = /^([a-z_:][a-z0-9_:]*)(\{(.*)\})? (\S+)$/.exec(line) ?? fail(`not a sample: ${line}`);
    const [, name, , inside, value] = m, labels = {};
    let rest = inside ?? '';
    while (rest) {
        const l = /^([a-z_][a-z0-9_]*)="((?:[^"\\\n]|\\[\\"n])*)"(,(?=.)|$)/.exec(rest) ?? fail(`labels of ${line}`);
        if (l[1] in labels) fail(`${l[1]} twice in ${line}`);
        labels[l[1]] = l[2];
        rest = rest.slice(l[0].length);
    }
    const ends = family.type === 'histogram' ? ['_bucket', '_sum', '_count'] : [''];
    if (!ends.some((end) => name === family.name + end)) fail(`${name} stands under ${family.name}`);
    return { name, labels, value: number(value), series: line.slice(0, line.lastIndexOf(' ')) };
}

export function read(text) {
    const families = new Map(), series = new Set();
    let family = null, help = null;
    if (!text.endsWith('\n')) fail('the last line has no end');
    for (const line of text.slice(0, -1).split('\n')) {
        const h = /^# HELP (\S+) (\S.*[^ ])$/.exec(line), t = /^# TYPE (\S+) (counter|gauge|histogram)$/.exec(line);
        if (h) {
            if (families.has(h[1])) fail(`${h[1]} has two parts`);
            help = h[1];
        } else if (t) {
            if (help !== t[1]) fail(`TYPE of ${t[1]} without its HELP before`);
            family = { name: t[1], type: t[2], samples: [] };
            families.set(t[1], family);
            help = null;
        } else {
            if (!family || help) fail(`a sample without HELP and TYPE: ${line}`);
            const sample = readSample(line, family);
            if (series.has(sample.series)) fail(`${sample.series} is there twice`);
            series.add(sample.series);
            family.samples.push(sample);
        }
    }
    return families;
}

const labelsAllowed = new Set(['build', 'isa', 'kind', 'le', 'level', 'method', 'outcome', 'reason', 'route', 'stage', 'state',
    'status', 'verdict']);
const mayBeEmpty = new Set(['shearwater_http_requests_total']); // before the first request has ended
const scaled = /_(ms|us|ns|millis\w*|micros\w*|nanos\w*|minutes?|hours?|days?|kb|mb|gb|[kmgt]i?bytes|percent|pct|bits)(_|$)/;

function checkName({ name, type }) {
    if (!/^(shearwater|process)_[a-z0-9]+(_[a-z0-9]+)*$/.test(name)) fail(`the name ${name}`);
    if (scaled.test(name)) fail(`${name} has no base unit`);
    if ((type === 'counter') !== name.endsWith('_total')) fail(`${name} is a ${type}`);
    if (/_(count|sum|bucket)$/.test(name)) fail(`${name} ends like a part of a histogram`);
    if (/(seconds|bytes)/.test(name) && !/_(seconds|bytes)(_total)?$/.test(name)) fail(`the unit of ${name} is not last`);
    if (type === 'histogram' && !name.endsWith('_seconds')) fail(`the unit of ${name}`);
}

function checkHistogram(family) {
    const groups = new Map();
    for (const s of family.samples) {
        const { le, ...rest } = s.labels, key = JSON.stringify(rest);
        if (!groups.has(key)) groups.set(key, { bounds: [] });
        const group = groups.get(key), part = s.name.slice(family.name.length + 1);
        if ((part === 'bucket') !== (le !== undefined)) fail(`le of ${s.series}`);
        if (part === 'bucket') group.bounds.push([le === '+Inf' ? Infinity : number(le), s.value]);
        else group[part] = s.value;
    }
    for (const [key, { bounds, sum, count }] of groups) {
        const at = `${family.name} ${key}`;
        for (let i = 1; i < bounds.length; i++) {
            if (!(bounds[i][0] > bounds[i - 1][0])) fail(`bounds of ${at}`);
            if (bounds[i][1] < bounds[i - 1][1]) fail(`buckets of ${at} do not add up`);
        }
        if (bounds.length < 2 || bounds.length > 20) fail(`${bounds.length} buckets in ${at}`);
        if (bounds.at(-1)[0] !== Infinity || bounds.at(-1)[1] !== count) fail(`+Inf of ${at} is not its count`);
        if (!(sum >= 0) || (count === 0 && sum !== 0)) fail(`sum of ${at}`);
    }
}

function check(families) {
    for (const family of families.values()) {
        checkName(family);
        if (family.samples.length === 0 && !mayBeEmpty.has(family.name)) fail(`${family.name} has no sample`);
        for (const s of family.samples) {
            if (!(s.value >= 0)) fail(`${s.series} is below zero`);
            for (const [name, value] of Object.entries(s.labels)) {
                if (!labelsAllowed.has(name)) fail(`the label ${name} of ${s.series} may have any number of values`);
                if (value === '' || value.length > 96) fail(`the value of ${name} in ${s.series}`);
                if (name === 'route' && !/^(none|\/[a-z0-9\/._{}]*)$/.test(value)) fail(`the route of ${s.series}`);
                if (name === 'status' && !/^[1-5]\d\d$/.test(value)) fail(`the status of ${s.series}`);
            }
        }
        if (family.name.endsWith('_info') && family.samples.some((s) => s.value !== 1)) fail(`${family.name} is not 1`);
        if (family.type === 'histogram') checkHistogram(family);
    }
}

const all = (families) => [...families.values()].flatMap((f) => f.samples.map((s) => ({ ...s, type: f.type })));
const [, , what, ...files] = process.argv;
const [a, b] = files.slice(0, what === 'value' ? 1 : 2).map((f) => read(readFileSync(f, 'utf8')));
try {
    if (what === 'check') check(a);
    if (what === 'same') {
        const before = new Set(all(a).map((s) => s.series));
        const fresh = all(b).filter((s) => !before.has(s.series));
        if (fresh.length > 0) fail(`new series: ${fresh.map((s) => s.series).join('\n')}`);
    }
    if (what === 'grows') {
        const before = new Map(all(a).map((s) => [s.series, s.value]));
        for (const s of all(b))
            if (s.type !== 'gauge' && s.value < (before.get(s.series) ?? 0)) fail(`${s.series} went back to ${s.value}`);
    }
    if (what === 'value')
        console.log((all(a).find((s) => s.series === files[1]) ?? fail(`no ${files[1]}`)).value);
} catch (error) {
    console.error(error.message);
    process.exit(1);
}
