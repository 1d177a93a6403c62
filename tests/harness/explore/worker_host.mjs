// node worker_host.mjs PAGE.html JOB.json: the worker of a page, with the modules of the page, without a browser. It answers jobs one
// after the other; what it says of slopes is written.
import fs from 'fs';
import vm from 'vm';
import zlib from 'zlib';

const { jobs, result } = JSON.parse(fs.readFileSync(process.argv[3])), page = fs.readFileSync(process.argv[2], 'utf8');
const script = (id) => page.match(new RegExp(`<script type="[a-z/]*" id="${id}">([^]*?)</script>`))[1];
const data = JSON.parse(script('data')), of = (kind) => data.variants.map((_, k) => script(`${kind}${k}`));
const modules = (kind) => of(kind).map((text) => new Uint8Array(zlib.gunzipSync(Buffer.from(text, 'base64'))).buffer);
const usual = Object.fromEntries(data.parameters.map((p) => [p.name, p.value])), step = data.steps.findIndex((s) => s.length === data.step);
const answers = [];
const ask = () => setTimeout(() => onmessage({ data: { id: answers.length, variant: 0, values: {}, step, extrapolation: data.extrapolation, ...jobs[answers.length] } }));
globalThis.onmessage = null;
globalThis.postMessage = (message) => {
    if (!['slope', 'refused', 'error'].includes(message.kind)) return;
    answers.push(message);
    if (answers.length < jobs.length) return void ask();
    fs.writeFileSync(result, JSON.stringify(answers));
    process.exit(0);
};
vm.runInThisContext(script('worker'));
onmessage({ data: { data: { ...data, usual, sliders: [] }, modules: modules('module') } });
onmessage({ data: { tangents: modules('tangents') } });
ask();
