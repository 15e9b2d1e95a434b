// A page that is served while the run goes on: it asks for the document again and again.

const pollInterval = 500;     // ms after the last answer
const longestInterval = 5000;  // after failures
const answerTimeout = 10000;

class Poller {
  /**
   * @param revision  function that tells which revision the page shows, null: none yet.
   * @param onAnswer  called with what came.
   * @param onFailure  called when nobody answers.
   */
  constructor(url, revision, onAnswer, onFailure) {
    Object.assign(this, {url, revision, onAnswer, onFailure, interval: pollInterval});
    this.poll();
  }

  async poll() {
    const revision = this.revision();
    try {
      const query = revision === null ? '' : `?revision=${revision}`;
      const answer = await fetch(this.url + query,
                                 {cache: 'no-store', signal: AbortSignal.timeout(answerTimeout)});
      if (!answer.ok) throw new Error(`answer ${answer.status}`);
      this.onAnswer(await answer.json());
      this.interval = pollInterval;
    } catch (error) {
      this.onFailure(error);
      this.interval = Math.min(2 * this.interval, longestInterval);
    }
    setTimeout(() => this.poll(), this.interval);
  }
}
