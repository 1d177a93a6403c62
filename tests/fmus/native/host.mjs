// node host.mjs JOB.json: a host of FMI 3 for a core module of WebAssembly. It steps an instance with given inputs and writes
// the outputs after initialization and after each step as doubles; messages go to the standard error.
import fs from 'fs';

const job = JSON.parse(fs.readFileSync(process.argv[2]));
const module = new WebAssembly.Module(fs.readFileSync(job.library));
const imported = WebAssembly.Module.imports(module).map(i => `${i.module}.${i.name}`).join();
if (imported !== 'host.log') throw new Error(`imports ${imported}`);
const at = address => {
    const bytes = new Uint8Array(x.memory.buffer, address);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
};
const log = (environment, status, category, message) => console.error(`${status} ${at(category)}: ${at(message)}`);
const x = new WebAssembly.Instance(module, {host: {log}}).exports;
x._initialize();
if (x.__stack_pointer && x.__stack_pointer.value !== 1048576) throw new Error('the stack does not come first');

const bytes = content => { const p = x.malloc(content.length); new Uint8Array(x.memory.buffer, p).set(content); return p; };
const text = string => bytes(new TextEncoder().encode(string + '\0'));
const words = numbers => bytes(new Uint8Array(Uint32Array.from(numbers).buffer));
const done = (status, what) => { if (status) { console.error(`${what}: status ${status}`); process.exit(1); } };

const name = text('unit'), token = text(job.token);
const instantiate = () => x.fmi3InstantiateCoSimulation(name, token, 0, 0, 1, 0, 0, 0, 0, 0, x.host_logger(), 0);
let c = instantiate();
if (!c) process.exit(1);
const inputs = words(job.inputs), parameters = words(job.parameters);
const given = x.malloc(8 * job.given + 8), results = x.malloc(8 * job.count + 8), flags = x.malloc(16), last = x.malloc(8);
const put = (references, n, values) => {
    new Float64Array(x.memory.buffer, given, values.length).set(values);
    done(x.fmi3SetFloat64(c, references, n, given, values.length), 'fmi3SetFloat64');
};
const rows = new Float64Array((job.steps + 1) * job.count);
const arrays = {Float64: Float64Array, Int32: Int32Array, Boolean: Uint8Array};
const outputs = job.outputs.map(([type, references, count]) => ({type, count, many: references.length, at: words(references)}));
const read = k => {
    let row = k * job.count;
    for (const {type, count, many, at} of outputs) { // outputs of one type
        done(x[`fmi3Get${type}`](c, at, many, results, count), `fmi3Get${type}`);
        rows.set(new arrays[type](x.memory.buffer, results, count), row);
        row += count;
    }
};
const driven = new Float64Array(new Uint8Array(fs.readFileSync(job.driven)).buffer); // a copy: small files share a buffer
const restore = content => {
    const state = words([0]), kept = bytes(content);
    done(x.fmi3DeserializeFMUState(c, kept, content.length, state), 'fmi3DeserializeFMUState');
    done(x.fmi3SetFMUState(c, new Uint32Array(x.memory.buffer, state, 1)[0]), 'fmi3SetFMUState');
};
if (job.state) {
    restore(fs.readFileSync(job.state)); // of another machine, after initialization
    read(0);
} else {
    done(x.fmi3EnterInitializationMode(c, 0, 0, 0, 0, 0), 'fmi3EnterInitializationMode');
    if (job.parameters.length) put(parameters, job.parameters.length, job.values);
    read(0);
    done(x.fmi3ExitInitializationMode(c), 'fmi3ExitInitializationMode');
}
for (let k = 0; k < job.steps; k++) {
    if (k === job.restored) { // the state goes, as bytes, to another instance
        const state = words([0]), size = words([0]);
        done(x.fmi3GetFMUState(c, state), 'fmi3GetFMUState');
        const held = new Uint32Array(x.memory.buffer, state, 1)[0];
        done(x.fmi3SerializedFMUStateSize(c, held, size), 'fmi3SerializedFMUStateSize');
        const n = new Uint32Array(x.memory.buffer, size, 1)[0], content = x.malloc(n);
        done(x.fmi3SerializeFMUState(c, held, content, n), 'fmi3SerializeFMUState');
        x.fmi3FreeInstance(c);
        c = instantiate();
        restore(new Uint8Array(x.memory.buffer, content, n).slice());
    }
    if (job.given) put(inputs, job.inputs.length, driven.subarray(k * job.given, (k + 1) * job.given));
    done(x.fmi3DoStep(c, k * job.step, job.step, 0, flags, flags + 1, flags + 2, last), `fmi3DoStep ${k}`);
    read(k + 1);
}
done(x.fmi3Terminate(c), 'fmi3Terminate');
x.fmi3FreeInstance(c);
fs.writeFileSync(job.result, new Uint8Array(rows.buffer));
