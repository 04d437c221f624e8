"""How fast jaxwalk is on this machine: `jaxwalk bench`. ``docs/benchmark.md`` says how each figure is measured.

benchmark_settings.py      what to measure
processes.py     each part runs in a process of its own; __main__.py is what such a process does
machine.py  simulation.py  training_speed.py  products.py  starting.py  streets.py     the parts
quantities.py    from measured rows to figures with names
document.py      everything as one document
showing.py  drawing.py     the document as a table, as Markdown, as plots
gpu_plan.py     `jaxwalk bench --plan`: programs compiled for a GPU without one, and the speeds that follow from them
gpu_programs.py  thunks.py  h100.txtpb     the programs; what they launch, by XLA's files; the GPU's description
"""
