// The manifests of an overlay against the schemas of Kubernetes and KEDA, offline. Fields that the schemas do not know
// are refused, and so is what the manifests say of each other and does not hold.
//   check.mjs FILE.yaml     what kustomize makes of an overlay; "-": standard input
//   check.mjs DIR           a folder with a kustomization.yaml; of kustomize only resources, namespace and images
// Exit status 0 when all is well; else what is wrong on standard output.
import { readFileSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(new URL("../../browser/", import.meta.url));
const { parseAllDocuments } = require("yaml");
const wrong = [];

// YAML 1.1, as Kubernetes reads it (0440 is octal); an alias is a copy.
function read(text, name) {
  return parseAllDocuments(text, { version: "1.1", merge: true }).map((document) => {
    for (const error of document.errors) wrong.push(`${name}: ${error.message}`);
    return document.toJS();
  }).filter((object) => object !== null);
}

const KUSTOMIZE = new Set(["apiVersion", "kind", "namespace", "resources", "images"]);
function build(folder) {
  const path = join(folder, "kustomization.yaml");
  const [kustomization] = read(readFileSync(path, "utf8"), path);
  for (const member of Object.keys(kustomization))
    if (!KUSTOMIZE.has(member)) wrong.push(`${path}: ${member} is not known here: ask kustomize`);
  const objects = kustomization.resources.flatMap((resource) => {
    const at = join(folder, resource);
    return statSync(at).isDirectory() ? build(at) : read(readFileSync(at, "utf8"), at);
  });
  for (const object of objects) {
    if (kustomization.namespace && object.kind !== "Namespace") object.metadata.namespace ??= kustomization.namespace;
    for (const container of object.spec?.template?.spec?.containers ?? [])
      for (const image of kustomization.images ?? [])
        if (container.image === image.name) container.image = `${image.newName ?? image.name}:${image.newTag}`;
  }
  return objects;
}

// A validator reads each property that its schema knows, by its name or in turn. The others are those nobody knows.
function watched(value, path, unread) {
  if (value === null || typeof value !== "object") return value;
  const children = new Map();
  for (const key of Object.keys(value)) {
    children.set(key, watched(value[key], `${path}/${key}`, unread));
    if (!Array.isArray(value)) unread.add(`${path}/${key}`);
  }
  return new Proxy(value, {
    get(target, key) {
      unread.delete(`${path}/${String(key)}`);
      return children.has(key) ? children.get(key) : target[key];
    },
  });
}

function modelOf({ apiVersion, kind }) {
  const room = apiVersion.startsWith("keda.sh/") ? "@kubernetes-models/keda" : "kubernetes-models";
  try {
    return require(`${room}/${apiVersion}/${kind}`)[kind];
  } catch {
    return null;
  }
}

function checkSchema(object) {
  const name = `${object.kind} ${object.metadata?.name}`, unread = new Set(), model = modelOf(object);
  if (!model) { wrong.push(`${name}: there is no schema of ${object.apiVersion}`); return; }
  try {
    model.prototype.validate.call(watched(object, "", unread));
  } catch (error) {
    wrong.push(`${name}: ${error.message}`);
  }
  for (const path of unread)
    if (![...unread].some((other) => path.startsWith(`${other}/`))) wrong.push(`${name}: ${path} is no field`);
}

// What no schema says: labels that select, ports, volumes and Secrets that names stand for.
const has = (labels, wanted) => Object.entries(wanted ?? {}).every(([key, value]) => labels?.[key] === value);
function checkPods(objects) {
  const pods = objects.filter((o) => o.spec?.template?.spec?.containers);
  const labels = pods.map((o) => o.spec.template.metadata.labels);
  const selects = (selector, who) => {
    if (!labels.some((l) => has(l, selector))) wrong.push(`${who}: its selector selects no pod`);
  };
  for (const o of pods) {
    const { template } = o.spec, who = `${o.kind} ${o.metadata.name}`;
    if (!has(template.metadata.labels, o.spec.selector.matchLabels)) wrong.push(`${who}: does not select its own pods`);
    const volumes = new Set([...(template.spec.volumes ?? []), ...(o.spec.volumeClaimTemplates ?? []).map((c) => c.metadata)].map((v) => v.name));
    const safe = template.spec.securityContext;
    if (!safe?.runAsNonRoot || safe.seccompProfile?.type !== "RuntimeDefault") wrong.push(`${who}: may run as root`);
    for (const c of template.spec.containers) {
      const ports = new Set((c.ports ?? []).map((p) => p.name));
      for (const mount of c.volumeMounts ?? []) if (!volumes.delete(mount.name)) wrong.push(`${who}: there is no volume ${mount.name}`);
      for (const probe of [c.startupProbe, c.readinessProbe, c.livenessProbe])
        if (probe && !ports.has(probe.httpGet.port)) wrong.push(`${who}: there is no port ${probe.httpGet.port}`);
      if (!c.securityContext?.readOnlyRootFilesystem || c.securityContext.allowPrivilegeEscalation !== false ||
          !c.securityContext.capabilities?.drop?.includes("ALL")) wrong.push(`${who}: its root can be written, or it has capabilities`);
    }
    for (const name of volumes) wrong.push(`${who}: volume ${name} is mounted nowhere`);
    for (const v of template.spec.volumes ?? [])
      if (v.secret && v.secret.defaultMode !== 0o440) wrong.push(`${who}: others may read ${v.name}`);
  }
  for (const o of objects) {
    const who = `${o.kind} ${o.metadata.name}`;
    if (o.kind === "Service") selects(o.spec.selector, who);
    if (o.kind === "PodDisruptionBudget") selects(o.spec.selector.matchLabels, who);
    if (o.kind === "NetworkPolicy") selects(o.spec.podSelector.matchLabels, who);
    const target = o.spec?.scaleTargetRef;
    if (target && !objects.some((t) => t.kind === target.kind && t.metadata.name === target.name)) wrong.push(`${who}: there is no ${target.name}`);
    if (o.kind === "Deployment" && objects.some((s) => s.spec?.scaleTargetRef) && o.spec.replicas !== undefined)
      wrong.push(`${who}: says how many it is, and so does a scaler`);
    if (o.kind !== "Namespace" && o.metadata.namespace !== "shearwater") wrong.push(`${who}: is in no namespace`);
  }
}

const from = process.argv[2];
const objects = from !== "-" && statSync(from).isDirectory() ? build(from) : read(readFileSync(from === "-" ? 0 : from, "utf8"), from);
objects.forEach(checkSchema);
if (wrong.length === 0) checkPods(objects);
if (objects.length === 0) wrong.push("there is nothing");
wrong.forEach((line) => console.log(line));
if (wrong.length === 0) console.log(objects.map((o) => `${o.kind} ${o.metadata.name}`).sort().join("\n"));
process.exitCode = wrong.length > 0 ? 1 : 0;
