// Browsers start no worker for a page that was opened from disk, and the search is one: there it runs in a hidden frame.
"use strict"

class WorkerInFrame {
  constructor(address) {
    this.waiting = []
    this.frame = document.createElement("iframe")
    this.frame.hidden = true
    this.frame.title = "search"
    this.frame.srcdoc = "<!doctype html>"
    this.frame.addEventListener("load", () => this.begin(String(new URL(address, location.href))), { once: true })
    document.body.append(this.frame)
  }

  begin(address) {
    const inside = this.frame.contentWindow
    inside.postMessage = data => setTimeout(() => this.onmessage && this.onmessage({ data }))
    const script = inside.document.createElement("script")
    script.src = address
    script.onerror = event => this.onerror && this.onerror(event)
    script.onload = () => {
      this.inside = inside
      this.waiting.forEach(data => this.postMessage(data))
    }
    inside.document.head.append(script)
  }

  postMessage(data) {
    if (this.inside) this.inside.dispatchEvent(new this.inside.MessageEvent("message", { data }))
    else this.waiting.push(data)
  }

  terminate() {
    this.frame.remove()
  }
}

if (location.protocol === "file:") window.Worker = WorkerInFrame
