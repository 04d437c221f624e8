"""Exports: episodes as pictures, pages and files of other tools; policies as files to share or as ONNX."""
