"""What others can use: episodes as pictures, pages and files of other tools; policies to share or as ONNX."""
