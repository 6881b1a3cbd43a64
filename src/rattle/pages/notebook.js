// The viewer inside of a notebook: its scene comes with the widget, motions of other parameters from the page itself or,
// where it cannot compute them, from the kernel.

const KERNEL_SILENT = 10; // seconds after which a kernel that does not answer counts as gone

// Asks the kernel for the motion of these parameters; the latest wish counts, the kernel leaves out those before it.
function askKernel(model, tasks, parameters, wish) {
  const id = (tasks.count = (tasks.count ?? 0) + 1);
  const promise = new Promise((resolve, reject) => {
    const silent = setTimeout(() => {
      tasks.delete(id);
      reject(new Error("the kernel of this notebook does not answer: it is busy, or it does not run; run the cell again"));
    }, 1000 * KERNEL_SILENT);
    tasks.set(id, { resolve, reject, heard: () => clearTimeout(silent), progress: wish.progress });
  });
  model.send({ do: "compute", id, parameters, t_end: wish.t_end ?? null });
  return { promise, cancel: () => { if (tasks.has(id)) model.send({ do: "cancel", id }); } };
}

function takeAnswer(tasks, answer) {
  const task = tasks.get(answer.id);
  if (!task) return;
  task.heard();
  if (answer.share !== undefined) return void task.progress?.(answer.share);
  if (answer.run === undefined && answer.error === undefined) return;
  tasks.delete(answer.id);
  if (answer.error === undefined) task.resolve(answer.run);
  else task.reject(new Error(answer.error));
}

function render({ model, el }) {
  const scene = JSON.parse(model.get("scene")), tasks = new Map();
  const answered = (answer) => takeAnswer(tasks, answer);
  model.on("msg:custom", answered);
  const host = model.get("by_kernel") ? { compute: (parameters, wish = {}) => askKernel(model, tasks, parameters, wish) } : {};
  const app = mount(el, scene, host);
  el.rattle = app;
  return () => {
    model.off("msg:custom", answered);
    for (const task of tasks.values()) task.heard();
    app.destroy();
  };
}

export default { render };
